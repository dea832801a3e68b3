"""Clouds inside figures: placing renders, colours by position and error, captions, landmarks."""

from dataclasses import dataclass
from textwrap import wrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import FuncNorm, LinearSegmentedColormap, to_rgb
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from reports.figures.point_renderer import Camera, render_points
from reports.figures.style import ABSENT, INK, QUIET, blank

ERROR_CAP = 25.0
"""Geodesic error x100 / sqrt(area) at which the error colours end."""

FILL = 2.5
"""A target point that nothing was mapped to takes the nearest colour within this many spacings."""

ERROR_COLORS = LinearSegmentedColormap.from_list(
    "error", ["#fdf6d3", "#fdd49e", "#fc8d59", "#d7301f", "#67000d"]
)
"""Pale yellow where a map is right, dark red where it is wrong; lightness alone tells them apart."""

SMALL = 0.5
"""Error from which the colours go with the logarithm: below 1, maps differ, too."""


def _to_scale(errors: ArrayLike) -> NDArray[np.float64]:
    return np.asarray(np.log1p(np.asarray(errors, float) / SMALL))


def _from_scale(values: ArrayLike) -> NDArray[np.float64]:
    return np.asarray(SMALL * np.expm1(np.asarray(values, float)))


ERROR_NORM = FuncNorm((_to_scale, _from_scale), 0.0, ERROR_CAP, clip=True)
"""From an error to its place in the colours."""
ERROR_TICKS = (0.0, 0.5, 1.0, 2.5, 5.0, 10.0, 25.0)


LETTER = 0.085
"""Width of a letter of a head, inches."""


@dataclass(frozen=True)
class DrawnCloud:
    """A cloud to be drawn.

    Attributes
    ----------
    points, normals : (n, 3) float64
    caption : str
        Small print over the picture.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    caption: str


def position_colors(positions: ArrayLike, low: ArrayLike, high: ArrayLike) -> NDArray[np.float64]:
    """Colour of a place: its coordinates become red, green and blue, kept bright enough to shade.

    Half of a colour is the position in a box, half its rank among all positions: ranks tell apart what
    is close together, such as the legs of a body with its arms stretched out.

    Parameters
    ----------
    positions : (n, 3)
    low, high : (3,)
        Corners of the box; an axis shorter than the longest one uses less than the whole range.

    Returns
    -------
    (n, 3) float64
    """
    box_low, box_high = np.asarray(low, float), np.asarray(high, float)
    extent = np.maximum(box_high - box_low, 0.35 * (box_high - box_low).max() + 1e-300)
    places = np.asarray(positions, float)
    inside = 0.5 + (places - 0.5 * (box_low + box_high)) / extent
    rank = np.argsort(np.argsort(places, axis=0, kind="stable"), axis=0) / max(len(places) - 1, 1)
    return 0.18 + 0.8 * (0.5 * np.clip(inside, 0, 1) + 0.5 * rank)


def error_colors(errors: ArrayLike) -> NDArray[np.float64]:
    """Colour of a geodesic error x100 / sqrt(area), (n, 3)."""
    return np.asarray(ERROR_COLORS(ERROR_NORM(np.asarray(errors, float)))[:, :3])


def carried_colors(
    source_to_target: NDArray[np.integer], colors: NDArray[np.float64], target: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Colours that arrive at the target: the mean of those sent to a point.

    Points that receive none take the nearest colour within `FILL` spacings, or else `ABSENT`.

    Parameters
    ----------
    source_to_target : (n,)
        -1 for no match.
    colors : (n, 3)
    target : (m, 3)

    Returns
    -------
    (m, 3) float64
    """
    m = len(target)
    sent = source_to_target >= 0
    count = np.bincount(source_to_target[sent], minlength=m)
    total = np.stack([np.bincount(source_to_target[sent], c, minlength=m) for c in colors[sent].T], axis=1)
    result = np.tile(to_rgb(ABSENT), (m, 1))
    reached = np.flatnonzero(count)
    result[reached] = total[reached] / count[reached, None]
    origin = colored_from(source_to_target, target)
    result[origin >= 0] = result[origin[origin >= 0]]
    return result


def colored_from(source_to_target: NDArray[np.integer], target: NDArray[np.float64]) -> NDArray[np.int64]:
    """The target point whose colour each target point has: itself if something is mapped to it.

    Else the nearest one within `FILL` spacings to which something is; -1 where there is none.

    Parameters
    ----------
    source_to_target : (n,)
        -1 for no match.
    target : (m, 3)

    Returns
    -------
    (m,) int64
    """
    reached, m = np.unique(source_to_target[source_to_target >= 0]), len(target)
    origin = np.full(m, -1, dtype=np.int64)
    origin[reached] = reached
    if len(reached) and m > 1:
        spacing = float(np.median(cKDTree(target).query(target, k=2)[0][:, 1]))
        gap, nearest = cKDTree(target[reached]).query(target)
        near = gap <= FILL * spacing
        origin[near] = reached[nearest[near]]
    return origin


def place_cloud(
    axes: Axes,
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    colors: NDArray[np.float64],
    camera: Camera,
) -> None:
    """Render a cloud into an axes, which then has the pixels of the camera as its coordinates."""
    blank(axes)
    axes.imshow(render_points(points, normals, colors, camera), interpolation="antialiased")
    axes.set_xlim(0, camera.width)
    axes.set_ylim(camera.height, 0)


def mark_landmarks(
    axes: Axes, points: NDArray[np.float64], normals: NDArray[np.float64], camera: Camera
) -> None:
    """Number points of a cloud that `place_cloud` has drawn; those on the far side are fainter.

    Equal numbers in the pictures of source and target are one landmark.
    """
    toward = normals @ camera.rotation[2]
    for number, (column, row, _) in enumerate(camera.project(points), start=1):
        strength = 0.95 if toward[number - 1] > 0 else 0.5
        axes.plot(column, row, "o", ms=8.5, mfc="white", mec=INK, mew=0.9, alpha=strength, clip_on=False)
        axes.text(
            column, row, str(number), ha="center", va="center_baseline", fontsize=6, color=INK, alpha=strength
        )


def caption(axes: Axes, title: str, note: str) -> None:
    """Head, in two lines if it is long, and a line of small print over a picture."""
    inches = axes.get_window_extent().width / axes.figure.dpi
    letters = max(int(inches / LETTER), 12)
    axes.set_title("\n".join(wrap(title, letters, max_lines=2, placeholder=" …")), pad=15)
    note = _shortened(note, max(int(1.8 * letters), 28))
    axes.text(0, 1.015, note, transform=axes.transAxes, fontsize=7.5, color=QUIET, va="bottom")


def _shortened(text: str, letters: int) -> str:
    """Without its middle, if it is too long: the ends of file names tell them apart."""
    half = (letters - 1) // 2
    return text if len(text) <= letters else f"{text[:half]}…{text[-half:]}"

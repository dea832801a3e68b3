"""Pictures of clouds inside figures: placing renders, colours by position, landmarks."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from numpy.typing import ArrayLike, NDArray

from reports.figures.style import INK, blank
from reports.render import Camera, render_points

ERROR_CAP = 25.0
"""Geodesic error x100 / sqrt(area) at which the error colours end."""

ERROR_COLORS = LinearSegmentedColormap.from_list(
    "error", ["#f1eef0", "#fdd49e", "#fc8d59", "#d7301f", "#67000d"]
)
"""Pale where a map is right, dark red where it is wrong; lightness alone tells them apart."""


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
    return ERROR_COLORS(np.clip(np.asarray(errors, float) / ERROR_CAP, 0, 1))[:, :3]


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

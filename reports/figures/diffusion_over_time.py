"""Fig. 4 of the paper: medial diffusion over time on a body that is thick and thin in turn, and its profile.

Where the medial balls are large, heat spreads fast and m_t(x, x) is low: above, the body with the medial
balls of some points; below, their m_t over time, and m_t at one time against the place along the body.
"""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray

from datasets_gen import Shape
from medial import Diffusion
from medial.spectrum.times import logarithmic_times
from reports.figures.cloud_drawing import place_cloud
from reports.figures.cloud_sheet import (
    EDGE,
    LINE,
    PIXELS,
    CloudPanel,
    CloudSheet,
    ColourBar,
    draw_bar,
    note_lines,
    put_note,
)
from reports.figures.figure_request import FigureRequest, MadeFigure
from reports.figures.signature_colours import (
    LABEL,
    SIGNATURE,
    few_ticks,
    shared_norm,
    signature_colors,
    signatures,
)
from reports.figures.style import INK, QUIET, plain_numbers, styled
from scanner_sim import Scan, sample

POSE = "straight"
POINTS = 4000
MARKED = {"a": "#d55e00", "b": "#e69f00", "c": "#009e73", "x": "#0072b2"}
"""Marked points, from the largest medial ball to the smallest, and their colours."""
TIMES = 60
SHOWN = 0.2
"""Where the time of the profile lies between the shortest and the longest, in the logarithm."""
WIDTH, LENGTH = 8.4, 7.2


@styled
def diffusion_over_time(request: FigureRequest) -> MadeFigure:
    """Follow the heat that stays at points with medial balls of several sizes.

    Parameters
    ----------
    request
        With a threshold, the body is scanned; without one it is sampled completely.
    """
    body = request.body("capsule_chain")
    shape = request.shapes(body, (POSE,), 1)[0]
    points = request.count(POINTS)
    cloud, about = _cloud(request, shape, points)
    diffusion = request.diffusion(cloud)
    times = logarithmic_times(diffusion.eigenvalues, count=TIMES)
    values = signatures(diffusion, times, body.reference.area)
    along = _along(cloud.points)
    frame = _frame(cloud.points)
    marks = marked_points(diffusion, frame[2])
    at = round(SHOWN * (TIMES - 1))
    note = (
        f"{shape.name}, {about}, {len(cloud):,} points, seed {request.seed}. Circles: the medial balls "
        "(Eq. 9) of four points, from the largest (a) to the smallest (x). Where balls are large, heat "
        "spreads fast, and less of it stays. m_t is multiplied by the body's area. The colours and the "
        f"profile are at the dotted time, t = {times[at]:.3g}."
    )
    settings = {"shape": shape.name, "points": points, "seed": request.seed, "cloud": about}
    figure = _drawn(cloud, diffusion, frame, along, times, values, marks, at, note)
    return MadeFigure(figure, _table(times, values, diffusion, along, marks, at), settings)


def _cloud(request: FigureRequest, shape: Shape, points: int) -> tuple[Scan, str]:
    """A complete sample, or a scan where a threshold is asked for."""
    if not request.thresholds:
        return sample(shape, points, request.seed), "sampled completely"
    threshold = request.threshold(0.3)
    scanned = request.whole_scan(shape, threshold, 10).subsample(points, request.seed)
    return scanned, f"10 views, threshold {threshold:g}"


def marked_points(diffusion: Diffusion, towards: NDArray[np.float64]) -> dict[str, int]:
    """Points of the side that is seen whose medial balls go from the largest to the smallest.

    Parameters
    ----------
    diffusion
    towards : (3,)
        Direction of the viewer.

    Returns
    -------
    dict
        Point id by name.
    """
    seen = np.flatnonzero(diffusion.normals @ towards > 0.7)
    seen = seen if len(seen) >= len(MARKED) else np.arange(len(diffusion))
    ranked = seen[np.argsort(-diffusion.radii[seen])]
    places = np.linspace(0.02, 0.95, len(MARKED))
    return {name: int(ranked[int(p * (len(ranked) - 1))]) for name, p in zip(MARKED, places, strict=True)}


def _frame(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Camera with the longest principal axis to the right and the shortest towards the viewer, (3, 3)."""
    _, axes = np.linalg.eigh(np.cov(points.T))
    right, up = axes[:, 2], axes[:, 1]
    right = right * np.sign(right[np.abs(right).argmax()])
    return np.array([right, up, np.cross(right, up)])


def _along(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Place along the longest principal axis, from 0 to 1, (n,)."""
    place = points @ _frame(points)[0]
    return np.asarray((place - place.min()) / max(np.ptp(place), 1e-300))


def _table(
    times: NDArray[np.float64],
    values: NDArray[np.float64],
    diffusion: Diffusion,
    along: NDArray[np.float64],
    marks: dict[str, int],
    at: int,
) -> pd.DataFrame:
    """Rows of the curves (panel "over time") and of the profile."""
    curves = [
        pd.DataFrame({"panel": "over time", "name": name, "point": i, "time": times, "area_m_t": values[i]})
        for name, i in marks.items()
    ]
    profile = pd.DataFrame(
        {
            "panel": "profile",
            "point": np.arange(len(diffusion)),
            "time": times[at],
            "area_m_t": values[:, at],
            "along": along,
            "radius": diffusion.radii,
        }
    )
    return pd.concat([*curves, profile], ignore_index=True)


def _drawn(
    cloud: Scan,
    diffusion: Diffusion,
    frame: NDArray[np.float64],
    along: NDArray[np.float64],
    times: NDArray[np.float64],
    values: NDArray[np.float64],
    marks: dict[str, int],
    at: int,
    note: str,
) -> Figure:
    norm = shared_norm([values[:, at]])
    size = float(np.ptp(cloud.points @ frame[0]))
    panel = CloudPanel(cloud.points, cloud.normals, signature_colors(values[:, at], norm), frame, size)
    camera = panel.camera(LENGTH)
    tall, lines = camera.height / PIXELS, note_lines(note, WIDTH)
    sheet = CloudSheet(WIDTH, tall + 3.95 + LINE * len(lines))
    axes = sheet.axes((WIDTH - camera.width / PIXELS) / 2, 0.35, camera.width / PIXELS, tall)
    place_cloud(axes, panel.points, panel.normals, panel.colors, camera)
    for name, i in marks.items():
        column, row, _ = camera.project(diffusion.centers[i][None])[0]
        ball = Circle((column, row), camera.scale * diffusion.radii[i], fill=False, ec=MARKED[name], lw=1.6)
        axes.add_patch(ball)
        ball.set_clip_on(False)
        column, row, _ = camera.project(cloud.points[i][None])[0]
        axes.plot(column, row, "o", ms=11, mfc="white", mec=MARKED[name], mew=1.3)
        axes.text(column, row, name, ha="center", va="center_baseline", fontsize=8, color=INK)
    top = tall + 0.5
    draw_bar(
        sheet,
        ColourBar(norm, SIGNATURE, f"{LABEL} at the dotted time", ticks=few_ticks(norm)),
        EDGE + 0.5,
        top,
        2.4,
    )
    top += 0.75
    _over_time(sheet.axes(0.75, top, 3.1, 2.15), times, values, marks, at)
    upper, lower = sheet.axes(4.75, top, 3.45, 1.35), sheet.axes(4.75, top + 1.5, 3.45, 0.65)
    _profile(upper, along, values[:, at], marks, "area · m_t", "m_t along the body")
    _profile(lower, along, diffusion.radii, marks, "ball radius", "")
    put_note(sheet, lines, top + 2.65)
    return sheet.figure


def _over_time(
    axes: Axes, times: NDArray[np.float64], values: NDArray[np.float64], marks: dict[str, int], at: int
) -> None:
    for name, i in marks.items():
        axes.plot(times, values[i], color=MARKED[name], label=name)
    axes.axvline(times[at], color=QUIET, lw=1, ls=":")
    axes.set_xscale("log")
    axes.set_yscale("log")
    plain_numbers(axes.xaxis)
    plain_numbers(axes.yaxis)
    axes.set_xlabel("time t")
    axes.set_ylabel(LABEL)
    axes.set_title("m_t over time")
    axes.legend(loc="upper right", handlelength=1.4)


def _profile(
    axes: Axes,
    along: NDArray[np.float64],
    values: NDArray[np.float64],
    marks: dict[str, int],
    label: str,
    title: str,
) -> None:
    axes.plot(along, values, ".", color=QUIET, ms=2, mew=0, alpha=0.35, rasterized=True)
    for name, i in marks.items():
        axes.plot(along[i], values[i], "o", color=MARKED[name], mec="white", mew=0.7, ms=6)
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1.05 * float(np.quantile(values, 0.999)))
    axes.set_ylabel(label)
    axes.set_title(title)
    if title:
        axes.tick_params(labelbottom=False)
    else:
        axes.set_xlabel("place along the body, from end to end")

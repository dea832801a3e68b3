"""Fig. 5 of the paper: the signature m_t(x, x) at several times, across poses and with data missing.

All clouds of a column share one colour scale, so that the two shoulders, and the poses, can be compared; the
curves on the right follow both shoulders over all times.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen import Collection, InputError
from medial.spectrum.times import logarithmic_times
from reports.figures.cloud_sheet import INNER, CloudPanel, ColourBar, cloud_sheet
from reports.figures.figure_request import UP, FigureRequest, MadeFigure, ScannedPose, cloud_table, front_view
from reports.figures.point_renderer import Camera
from reports.figures.signature_colours import (
    LABEL,
    SIGNATURE,
    few_ticks,
    shared_norm,
    signature_colors,
    signatures,
)
from reports.figures.style import INK, plain_numbers, styled

POSES = ("rest", "arms_up", "walk")
COMPLETE, MISSING = (0.1, 10), (0.8, 6)
"""Threshold and views of all rows but the last, and of the last."""
POINTS = 4000
TIMES = 25
SHOWN = (2, 7, 12, 17)
"""Times that are drawn, of all."""
SHOULDER = 0.8
"""Height at which the widest pair of mirrored places is marked, as a share of the body's."""
LEVEL = 0.03
SIDES = {"L": "#d55e00", "R": "#0072b2"}
PLOT = 2.3


@styled
def signature_at_times(request: FigureRequest) -> MadeFigure:
    """Draw the signature of one body in several poses; the last is scanned with a high threshold.

    Parameters
    ----------
    request

    Raises
    ------
    InputError
        If the body has no mirror map: there is no symmetric pair to compare.
    """
    body = request.body("human")
    if body.mirror is None:
        raise InputError(
            f"figure {request.number} compares a place with its mirror image, and {body.subject!r} has no "
            "mirror map; give a data set of a symmetric body"
        )
    shapes = request.shapes(body, POSES, 2)
    points = request.count(POINTS)
    holed = (request.threshold(MISSING[0]), MISSING[1])
    rows = [
        ScannedPose.of(request, shape, *(holed if shape is shapes[-1] else COMPLETE), points)
        for shape in shapes
    ]
    times = logarithmic_times(*(each.diffusion.eigenvalues for each in rows), count=TIMES)
    values = [signatures(each.diffusion, times, body.reference.area) for each in rows]
    marks = [shoulder_points(body, each) for each in rows]
    note = (
        f"{body.subject}: {COMPLETE[1]} views at threshold {COMPLETE[0]:g}; the last row has {holed[1]} "
        f"views at threshold {holed[0]:g}. At most {points:,} points, seed {request.seed}. Columns have "
        "one colour scale for all poses. L and R: the body's left and right shoulder, or what was scanned "
        "nearest to it; values are theirs. m_t is multiplied by the area of the body at rest."
    )
    settings = {
        "poses": [s.name for s in shapes],
        "threshold": holed[0],
        "points": points,
        "seed": request.seed,
    }
    table = pd.concat(
        [_table(each, times, found, pair) for each, found, pair in zip(rows, values, marks, strict=True)],
        ignore_index=True,
    )
    return MadeFigure(_drawn(body, rows, times, values, marks, note), table, settings)


def shoulder_vertices(body: Collection) -> tuple[int, int]:
    """The widest pair of mirrored vertices at `SHOULDER` of the height at rest: left, then right."""
    assert body.mirror is not None
    vertices = body.reference.vertices
    height = (vertices[:, UP] - vertices[:, UP].min()) / max(np.ptp(vertices[:, UP]), 1e-300)
    level = np.flatnonzero(np.abs(height - SHOULDER) < LEVEL)
    width = np.linalg.norm(vertices[level] - vertices[body.mirror[level]], axis=1)
    one = int(level[width.argmax()])
    other = int(body.mirror[one])
    side = (UP + 2) % 3  # a body faces the axis after `UP`, its left is the third
    return (one, other) if vertices[one, side] > vertices[other, side] else (other, one)


def shoulder_points(body: Collection, each: ScannedPose) -> tuple[int, int]:
    """Scanned points nearest to the shoulders, by their places on the body at rest."""
    places = body.canonical(each.shape, each.scan.face_ids, each.scan.barycentrics)
    wanted = body.reference.vertices[list(shoulder_vertices(body))]
    left, right = cKDTree(places).query(wanted)[1]
    return int(left), int(right)


def _table(
    each: ScannedPose, times: NDArray[np.float64], values: NDArray[np.float64], marks: tuple[int, int]
) -> pd.DataFrame:
    """A row per point with its signature at all times, and which shoulder it is."""
    names = np.full(len(each.scan), "", dtype=object)
    names[list(marks)] = list(SIDES)
    columns = {f"area_m_t_{k}": values[:, k] for k in range(len(times))}
    clock = {f"t_{k}": t for k, t in enumerate(times)}
    return cloud_table("signature", each, shoulder=names, missing=each.missing, **columns, **clock)


def _drawn(
    body: Collection,
    rows: Sequence[ScannedPose],
    times: NDArray[np.float64],
    values: Sequence[NDArray[np.float64]],
    marks: Sequence[tuple[int, int]],
    note: str,
) -> Figure:
    norms = [shared_norm([found[:, k] for found in values]) for k in SHOWN]
    panels = []
    for each, found, pair in zip(rows, values, marks, strict=True):
        row: list[CloudPanel | None] = []
        for k, norm in zip(SHOWN, norms, strict=True):
            row.append(
                CloudPanel(
                    each.scan.points,
                    each.scan.normals,
                    signature_colors(found[:, k], norm),
                    front_view(body),
                    body.reference.diagonal,
                    title=f"t = {float(f'{times[k]:.2g}'):g}",
                    note="  ".join(f"{name} {found[i, k]:.3g}" for name, i in zip(SIDES, pair, strict=True)),
                    overlay=_Marks(each, pair),
                )
            )
        panels.append(row)
    bars = [ColourBar(norm, SIGNATURE, LABEL, column, few_ticks(norm)) for column, norm in enumerate(norms)]
    names = [f"{each.shape.pose}, {100 * each.missing:.0f} % missing" for each in rows]
    sheet = cloud_sheet(panels, names=names, bars=bars, key=[INNER], note=note, right=PLOT + 0.75)
    top = 0.55
    shown = np.concatenate([found[list(pair)] for found, pair in zip(values, marks, strict=True)])
    each_tall = (sheet.bottom - 0.2) / len(rows)
    for number, (found, pair) in enumerate(zip(values, marks, strict=True)):
        axes = sheet.axes(sheet.right + 0.6, top + number * each_tall, PLOT, each_tall - 0.75)
        _curves(axes, times, found, pair)
        axes.set_ylim(shown.min() / 1.2, shown.max() * 1.2)
        if number == 0:
            axes.set_title("both shoulders over time")
            axes.legend(loc="upper right", handlelength=1.6)
        if number == len(rows) - 1:
            axes.set_xlabel("time t; dotted: the columns")
    return sheet.figure


class _Marks:
    """Draws the two shoulders on a cloud."""

    def __init__(self, each: ScannedPose, pair: tuple[int, int]) -> None:
        self._places = each.scan.points[list(pair)]

    def __call__(self, axes: Axes, camera: Camera) -> None:
        for name, (column, row, _) in zip(SIDES, camera.project(self._places), strict=True):
            axes.plot(column, row, "o", ms=9, mfc="white", mec=SIDES[name], mew=1.3, alpha=0.95)
            axes.text(column, row, name, ha="center", va="center_baseline", fontsize=6, color=INK)


def _curves(
    axes: Axes, times: NDArray[np.float64], found: NDArray[np.float64], pair: tuple[int, int]
) -> None:
    for (name, color), i, dash in zip(SIDES.items(), pair, ("-", "--"), strict=True):
        axes.plot(times, found[i], color=color, ls=dash, label=name)
    for k in SHOWN:
        axes.axvline(times[k], color=INK, lw=0.6, ls=":")
    axes.set_xscale("log")
    axes.set_yscale("log")
    plain_numbers(axes.xaxis)
    plain_numbers(axes.yaxis)
    axes.set_ylabel(LABEL)

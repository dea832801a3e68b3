"""Clouds in rows on a sheet laid out in inches: a body has one size in every figure, nothing is squeezed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from textwrap import wrap
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from reports.figures.cloud_drawing import mark_landmarks, place_cloud
from reports.figures.point_renderer import INSIDE, Camera
from reports.figures.style import ABSENT, DPI, INK, QUIET, NotebookFigure

BODY_INCHES = 2.5
"""Diagonal of a body at rest, on paper: the same in all figures."""
PIXELS = 240
"""Of a rendered cloud, per inch."""
MARGIN = 0.06
"""Free space round a cloud, inches."""
HEAD, GAP, EDGE = 0.42, 0.14, 0.14
"""Inches above a cloud for its title and note; between clouds; round the sheet."""
NARROWEST, LEAST_WIDTH = 1.3, 4.5
"""Width of a column of clouds, whose title must fit, and of the sheet, inches."""
LINE, BAR_HEIGHT, BAR_ROOM = 0.155, 0.09, 0.52
LETTERS, TITLE_LETTER = 18.5, 0.085
"""Letters of notes per inch; width of a letter of a title, inches."""

NEAR = Line2D([], [], marker="o", ls="", mfc="white", mec=INK, ms=6, label="landmark, on the side seen")
FAR = Line2D(
    [], [], marker="o", ls="", mfc="white", mec=INK, ms=6, alpha=0.5, label="landmark, on the far side"
)
INNER = Patch(color=tuple(0.8 * INSIDE), label="inner side, seen through a gap")
UNMATCHED = Patch(color=ABSENT, label="nothing is mapped to it")


KEY = (NEAR, FAR, INNER, UNMATCHED)
"""What the marks and greys of a map mean."""


def add_key(figure: Figure, handles: Sequence[Any] = KEY) -> None:
    """A key below a figure with constrained layout."""
    columns = max(min(int(figure.get_figwidth() / 2.3), len(handles)), 1)
    figure.legend(handles=list(handles), loc="outside lower left", ncols=columns, fontsize=7.5)


@dataclass(frozen=True)
class CloudPanel:
    """One cloud of a sheet.

    Attributes
    ----------
    points, normals, colors : (n, 3) float64
    rotation : (3, 3) float64
        Of the camera.
    size : float
        Diagonal of the body at rest, which is drawn `BODY_INCHES` long.
    title, note : str
    landmarks : (L,) int
        Points that are numbered.
    overlay : callable or None
        Draws on the axes, with the camera, after the cloud.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    colors: NDArray[np.float64]
    rotation: NDArray[np.float64]
    size: float
    title: str = ""
    note: str = ""
    landmarks: NDArray[np.integer] = field(default_factory=lambda: np.zeros(0, np.int64))
    overlay: Callable[[Axes, Camera], None] | None = None

    def camera(self, inches: float) -> Camera:
        """Camera that just holds the cloud, at the scale of the body."""
        scale = PIXELS * inches / self.size
        seen = self.points @ self.rotation[:2].T
        low, high = seen.min(axis=0), seen.max(axis=0)
        width, height = np.ceil(scale * (high - low) + 2 * MARGIN * PIXELS).astype(int)
        return Camera(self.rotation, (low + high) / 2, scale, int(width), int(height))


@dataclass(frozen=True)
class ColourBar:
    """A colour scale under the clouds: its range, its map, what it means, and the column it belongs to."""

    norm: mpl.colors.Normalize
    cmap: Any
    label: str
    column: int | None = None
    ticks: Sequence[float] | None = None


class CloudSheet:
    """A figure whose axes are placed in inches from its upper left corner.

    Attributes
    ----------
    figure : Figure
    bottom, right : float
        Where the rows and the columns of clouds end.
    """

    def __init__(self, width: float, height: float) -> None:
        self.figure = NotebookFigure(figsize=(width, height), dpi=DPI)
        FigureCanvasAgg(self.figure)
        self.width, self.height = width, height
        self.right, self.bottom = width, height
        self.columns: list[tuple[float, float]] = []

    def axes(self, left: float, top: float, width: float, height: float, **options: Any) -> Axes:
        """Axes by their upper left corner and size."""
        place = (
            left / self.width,
            1 - (top + height) / self.height,
            width / self.width,
            height / self.height,
        )
        return self.figure.add_axes(place, **options)

    def text(self, left: float, top: float, words: str, **options: Any) -> None:
        """Text by its upper left corner."""
        style: Any = {"va": "top", "ha": "left", "fontsize": 7.5, "color": QUIET} | options
        self.figure.text(left / self.width, 1 - top / self.height, words, **style)


def cloud_sheet(
    rows: Sequence[Sequence[CloudPanel | None]],
    *,
    names: Sequence[str] = (),
    bars: Sequence[ColourBar] = (),
    key: Sequence[Any] = (),
    note: str = "",
    right: float = 0.0,
    least_height: float = 0.0,
    inches: float = BODY_INCHES,
) -> CloudSheet:
    """Rows of clouds, colour scales, a key of all marks and a footnote.

    Parameters
    ----------
    rows
        None leaves a place empty.
    names
        Of the rows, written along them.
    bars
        Colour scales; one with a column stands under it.
    key
        Handles of a legend.
    note
        What was computed from what; wrapped.
    right
        Inches that are left free right of the clouds, for plots of the caller.
    least_height
        Of all rows together.
    inches
        Diagonal of a body at rest.
    """
    cameras = [[None if panel is None else panel.camera(inches) for panel in row] for row in rows]
    count = max(len(row) for row in rows)
    widths = [_column_width(rows, cameras, c) for c in range(count)]
    heights = [max(each.height / PIXELS for each in row if each is not None) for row in cameras]
    left = EDGE + (0.2 if names else 0.0)
    lefts = left + np.concatenate([[0.0], np.cumsum(np.add(widths, GAP))])
    top = EDGE + max(sum(heights) + len(rows) * (HEAD + GAP), least_height)
    width = max(float(lefts[-1]) + right + EDGE - GAP, LEAST_WIDTH)
    lines = note_lines(note, width)
    legend_rows, columns = _key_shape(key, width)
    height = (
        top
        + (BAR_ROOM if bars else 0)
        + (0.2 * legend_rows + 0.06) * bool(key)
        + LINE * len(lines)
        + EDGE / 2
    )
    sheet = CloudSheet(width, height)
    sheet.right, sheet.bottom = float(lefts[-1]), top
    sheet.columns = list(zip(lefts[:-1].tolist(), widths, strict=True))
    _place_rows(sheet, rows, cameras, heights, names)
    _place_foot(sheet, bars, key, columns, lines)
    return sheet


def _column_width(
    rows: Sequence[Sequence[CloudPanel | None]], cameras: Sequence[Sequence[Camera | None]], column: int
) -> float:
    """Inches that the clouds, titles and notes of a column need."""
    needed = [NARROWEST]
    for row, row_cameras in zip(rows, cameras, strict=True):
        panel, camera = (each[column] if column < len(each) else None for each in (row, row_cameras))
        if isinstance(panel, CloudPanel) and isinstance(camera, Camera):
            needed += [camera.width / PIXELS, TITLE_LETTER * len(panel.title), len(panel.note) / LETTERS]
    return max(needed)


def _place_rows(
    sheet: CloudSheet,
    rows: Sequence[Sequence[CloudPanel | None]],
    cameras: Sequence[Sequence[Camera | None]],
    heights: Sequence[float],
    names: Sequence[str],
) -> None:
    top = EDGE
    for number, (row, row_cameras, height) in enumerate(zip(rows, cameras, heights, strict=True)):
        top += HEAD
        for panel, camera, (left, width) in zip(row, row_cameras, sheet.columns, strict=False):
            if panel is None or camera is None:
                continue
            own_width, own_height = camera.width / PIXELS, camera.height / PIXELS
            axes = sheet.axes(
                left + (width - own_width) / 2, top + height - own_height, own_width, own_height
            )
            place_cloud(axes, panel.points, panel.normals, panel.colors, camera)
            if len(panel.landmarks):
                ids = panel.landmarks
                mark_landmarks(axes, panel.points[ids], panel.normals[ids], camera)
            if panel.overlay is not None:
                panel.overlay(axes, camera)
            sheet.text(left, top - 0.37, panel.title, fontsize=9, fontweight="bold", color=INK)
            sheet.text(left, top - 0.2, panel.note, fontsize=7)
        if names:
            middle = top + height / 2
            sheet.text(
                EDGE,
                middle,
                names[number],
                rotation=90,
                va="center",
                fontsize=9,
                fontweight="bold",
                color=INK,
            )
        top += height + GAP


def _place_foot(
    sheet: CloudSheet, bars: Sequence[ColourBar], key: Sequence[Any], columns: int, lines: Sequence[str]
) -> None:
    top, next_left = sheet.bottom, EDGE
    for bar in bars:
        left, width = (next_left, 1.9) if bar.column is None else sheet.columns[bar.column]
        draw_bar(sheet, bar, left + 0.06, top + 0.04, min(width, 2.2) - 0.12)
        next_left = left + width + 0.5
    top += BAR_ROOM if bars else 0
    if key:
        rows = -(-len(key) // columns)
        sheet.figure.legend(
            handles=list(key),
            loc="upper left",
            bbox_to_anchor=(EDGE / sheet.width, 1 - top / sheet.height),
            ncols=columns,
            fontsize=7.5,
            borderaxespad=0,
            borderpad=0,
            handletextpad=0.5,
            columnspacing=1.4,
        )
        top += 0.2 * rows + 0.06
    put_note(sheet, lines, top)


def note_lines(note: str, width: float) -> list[str]:
    """A footnote in lines that fit the width of a sheet, inches."""
    return wrap(note, max(int((width - 2 * EDGE) * LETTERS), 40))


def put_note(sheet: CloudSheet, lines: Sequence[str], top: float) -> None:
    """Write the lines of a footnote, from `top` inches down."""
    for number, line in enumerate(lines):
        sheet.text(EDGE, top + LINE * number, line, fontsize=7)


def draw_bar(sheet: CloudSheet, bar: ColourBar, left: float, top: float, width: float) -> None:
    """A horizontal colour scale with its label below."""
    axes = sheet.axes(left, top, width, BAR_HEIGHT)
    drawn = sheet.figure.colorbar(
        mpl.cm.ScalarMappable(bar.norm, bar.cmap), cax=axes, orientation="horizontal", ticks=bar.ticks
    )
    if bar.ticks is not None:
        drawn.set_ticks(list(bar.ticks), labels=[f"{tick:g}" for tick in bar.ticks])
        drawn.minorticks_off()
    axes.tick_params(labelsize=6.5, length=2, pad=1.5)
    axes.set_xlabel(bar.label, fontsize=7, labelpad=1.5)
    drawn.outline.set_visible(False)


def _key_shape(key: Sequence[Any], width: float) -> tuple[int, int]:
    """Rows and columns of a key that fits the width."""
    if not key:
        return 0, 1
    inches = 0.062 * max(len(str(handle.get_label())) for handle in key) + 0.5
    columns = min(max(int((width - 2 * EDGE) / inches), 1), len(key))
    return -(-len(key) // columns), columns

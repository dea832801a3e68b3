"""Fig. 8 of the paper: a dense correspondence as colours, methods side by side."""

from dataclasses import dataclass, field, replace
from textwrap import wrap

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from reports.figures.cloud_drawing import ERROR_CAP, ERROR_COLORS, error_colors, mark_landmarks, place_cloud
from reports.figures.point_renderer import Camera, best_azimuth, frame, look_from
from reports.figures.style import QUIET, blank, new_figure, styled

HEADROOM = 0.16
"""Inches above the first heads, which may take two lines."""

LETTER = 0.085
"""Width of a letter of a head, inches."""

PER_ROW = 5
"""Methods side by side before a new row begins."""


@dataclass(frozen=True)
class Cloud:
    """Points and normals of one side of a pair, each (n, 3), and its caption."""

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    caption: str


@dataclass(frozen=True)
class Panel:
    """What one method says.

    Attributes
    ----------
    title, note : str
        Method; its errors in a few words.
    target_colors : (n_target, 3) float64
        Colours that arrived.
    errors : (n_source,) float64
        Geodesic error x100 / sqrt(area) of every source point.
    landmarks : (L, 2) int64
        Source and target point ids.
    """

    title: str
    note: str
    target_colors: NDArray[np.float64]
    errors: NDArray[np.float64]
    landmarks: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 2), np.int64))


@dataclass(frozen=True)
class Pair:
    """Two clouds, the true correspondence and what each method makes of it.

    `source_colors` is (n_source, 3), `truth_colors` (n_target, 3), `up` the axis that points upwards.
    """

    source: Cloud
    target: Cloud
    source_colors: NDArray[np.float64]
    truth_colors: NDArray[np.float64]
    panels: tuple[Panel, ...]
    up: int = 1


@styled
def correspondence(pair: Pair, height: int = 420) -> Figure:
    """Picture of a pair: source and truth, then per method the colours that arrive and the error per point.

    Parameters
    ----------
    pair
    height
        Pixels of one cloud.
    """
    rotation = look_from(best_azimuth(pair.source.points, pair.up), up=pair.up)
    cameras = frame([pair.source.points, pair.target.points], rotation, height)
    width = max(camera.width for camera in cameras)
    source_camera, target_camera = (replace(camera, width=width) for camera in cameras)
    blocks = [pair.panels[i : i + PER_ROW] for i in range(0, len(pair.panels), PER_ROW)] or [()]
    columns = 1 + max(len(block) for block in blocks)
    tall = 2.8
    wide = max(tall * width / height, 1.5)
    figure, grid = new_figure(
        2 * len(blocks), columns, wide * columns + 0.6, 2 * (tall + 0.3) * len(blocks), HEADROOM
    )
    for axes in grid.flat:
        blank(axes)
    source, target = pair.source, pair.target
    place_cloud(grid[0, 0], source.points, source.normals, pair.source_colors, source_camera)
    caption(grid[0, 0], "source", source.caption)
    place_cloud(grid[1, 0], target.points, target.normals, pair.truth_colors, target_camera)
    caption(grid[1, 0], "target, truth", target.caption)
    for b, block in enumerate(blocks):
        for axes, panel in zip(grid[2 * b : 2 * b + 2, 1:].T, block, strict=False):
            _panel(axes[0], axes[1], pair, panel, source_camera, target_camera)
    _colorbar(figure, grid)
    return figure


def _panel(top: Axes, bottom: Axes, pair: Pair, panel: Panel, source: Camera, target: Camera) -> None:
    place_cloud(top, pair.target.points, pair.target.normals, panel.target_colors, target)
    caption(top, panel.title, panel.note)
    place_cloud(bottom, pair.source.points, pair.source.normals, error_colors(panel.errors), source)
    caption(bottom, "", "error per source point")
    if len(panel.landmarks):
        for axes, cloud, camera, column in ((bottom, pair.source, source, 0), (top, pair.target, target, 1)):
            ids = panel.landmarks[:, column]
            mark_landmarks(axes, cloud.points[ids], cloud.normals[ids], camera)


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


def _colorbar(figure: Figure, grid: np.ndarray) -> None:
    scale = mpl.cm.ScalarMappable(mpl.colors.Normalize(0, ERROR_CAP), ERROR_COLORS)
    bar = figure.colorbar(scale, ax=grid[1].tolist(), shrink=0.7, aspect=28, pad=0.01, extend="max")
    bar.set_label("geodesic error × 100 / √area")
    bar.outline.set_visible(False)

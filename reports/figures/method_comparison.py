"""Fig. 8 of the paper: a dense correspondence as colours, methods side by side."""

from dataclasses import dataclass, field

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from reports.figures.cloud_drawing import (
    ERROR_COLORS,
    ERROR_NORM,
    ERROR_TICKS,
    DrawnCloud,
    caption,
    error_colors,
    mark_landmarks,
    place_cloud,
)
from reports.figures.cloud_sheet import add_key
from reports.figures.pair_cameras import pair_cameras
from reports.figures.point_renderer import Camera
from reports.figures.style import CLOUD_INCHES, HEADROOM, blank, new_figure, styled

KEY_ROOM = 0.35
"""Inches for the key below."""
PER_ROW = 5
"""Methods side by side before a new row begins."""


@dataclass(frozen=True)
class MethodPanel:
    """The map of one method on a pair.

    Attributes
    ----------
    title, note : str
        Name of the method; its errors in a few words.
    target_colors : (n_target, 3) float64
        Colours that its map carries to the target, sRGB in [0, 1].
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
class PairPicture:
    """Two clouds, the true correspondence and the map of each method.

    Attributes
    ----------
    source, target : DrawnCloud
    source_colors : (n_source, 3) float64
    truth_colors : (n_target, 3) float64
        Colours that a perfect map carries to the target.
    panels : tuple of MethodPanel
    up : int
        Axis that points upwards: 0, 1 or 2.
    """

    source: DrawnCloud
    target: DrawnCloud
    source_colors: NDArray[np.float64]
    truth_colors: NDArray[np.float64]
    panels: tuple[MethodPanel, ...]
    up: int = 1


@styled
def method_comparison(pair: PairPicture, height: int = 420) -> Figure:
    """Picture of a pair: source and truth, then per method the colours that arrive and the error per point.

    Parameters
    ----------
    pair
    height
        Pixels of one cloud.
    """
    cameras = pair_cameras(pair.source, pair.target, pair.up, height)
    source_camera, target_camera = cameras.source, cameras.target
    blocks = [pair.panels[i : i + PER_ROW] for i in range(0, len(pair.panels), PER_ROW)] or [()]
    columns = 1 + max(len(block) for block in blocks)
    tall = CLOUD_INCHES
    wide = max(tall * source_camera.width / height, 1.5)
    figure, grid = new_figure(
        2 * len(blocks), columns, wide * columns + 0.6, 2 * (tall + 0.3) * len(blocks) + KEY_ROOM, HEADROOM
    )
    for axes in grid.flat:
        blank(axes)
    source, target = pair.source, pair.target
    place_cloud(grid[0, 0], source.points, source.normals, pair.source_colors, source_camera)
    caption(grid[0, 0], "source", source.caption)
    place_cloud(grid[1, 0], target.points, target.normals, pair.truth_colors, target_camera)
    caption(grid[1, 0], f"target, truth{cameras.words}", target.caption)
    for b, block in enumerate(blocks):
        for axes, panel in zip(grid[2 * b : 2 * b + 2, 1:].T, block, strict=False):
            _panel(axes[0], axes[1], pair, panel, source_camera, target_camera)
    _colorbar(figure, grid)
    add_key(figure)
    return figure


def _panel(
    top: Axes, bottom: Axes, pair: PairPicture, panel: MethodPanel, source: Camera, target: Camera
) -> None:
    place_cloud(top, pair.target.points, pair.target.normals, panel.target_colors, target)
    caption(top, panel.title, panel.note)
    place_cloud(bottom, pair.source.points, pair.source.normals, error_colors(panel.errors), source)
    caption(bottom, "", "error per source point")
    if len(panel.landmarks):
        for axes, cloud, camera, column in ((bottom, pair.source, source, 0), (top, pair.target, target, 1)):
            ids = panel.landmarks[:, column]
            mark_landmarks(axes, cloud.points[ids], cloud.normals[ids], camera)


def _colorbar(figure: Figure, grid: np.ndarray) -> None:
    scale = mpl.cm.ScalarMappable(ERROR_NORM, ERROR_COLORS)
    bar = figure.colorbar(
        scale, ax=grid[1].tolist(), shrink=0.7, aspect=28, pad=0.01, panchor=False, extend="max"
    )
    bar.set_ticks(list(ERROR_TICKS), labels=[f"{tick:g}" for tick in ERROR_TICKS])
    bar.minorticks_off()
    bar.set_label("geodesic error × 100 / √area")
    bar.outline.set_visible(False)

"""Clouds side by side, such as the scans of one pose at rising peak thresholds."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray

from reports.figures.cloud_drawing import place_cloud
from reports.figures.pair_cameras import TURNED, outside_cameras
from reports.figures.point_renderer import best_azimuth
from reports.figures.style import CLAY, CLOUD_INCHES, HEADROOM, QUIET, blank, new_figure, styled


@dataclass(frozen=True)
class ScanView:
    """One cloud: points and normals (n, 3), and its captions."""

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    title: str
    note: str


@styled
def scan_series(
    rows: Sequence[tuple[str, Sequence[ScanView]]],
    up: int = 1,
    height: int = 360,
    inches: float = CLOUD_INCHES,
) -> Figure:
    """Clouds side by side, one row per pose; what is seen through a hole is grey.

    All are seen from one side, but for those that would show their inner side: their note says so.

    Parameters
    ----------
    rows
        Name of each row and its clouds.
    up
        Axis that points upwards.
    height
        Pixels of the tallest cloud.
    inches
        Height of a cloud on paper.
    """
    every = [view for _, views in rows for view in views]
    azimuth = best_azimuth(every[0].points, up)
    framed = outside_cameras([(view.points, view.normals) for view in every], azimuth, up, height)
    cameras, width = iter(framed), framed[0][0].width
    columns = max(len(views) for _, views in rows)
    shown = [[(view, *next(cameras)) for view in views] for _, views in rows]
    wide = max(inches * width / height, 1.1)
    figure, grid = new_figure(len(rows), columns, wide * columns, (inches + 0.35) * len(rows), HEADROOM)
    for axes, row, (name, _) in zip(grid, shown, rows, strict=True):
        for each in axes:
            blank(each)
        for each, (view, camera, turned) in zip(axes, row, strict=False):
            colors = np.tile(to_rgb(CLAY), (len(view.points), 1))
            place_cloud(each, view.points, view.normals, colors, camera)
            each.set_title(view.title, pad=14)
            note = view.note + TURNED * turned
            each.text(0, 1.01, note, transform=each.transAxes, fontsize=7.5, color=QUIET, va="bottom")
        if len(rows) > 1:
            axes[0].text(
                -0.02,
                0.5,
                name,
                transform=axes[0].transAxes,
                rotation=90,
                va="center",
                ha="right",
                color=QUIET,
            )
    return figure

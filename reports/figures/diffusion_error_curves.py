"""Eq. 18 in results: the error in the diffusion against the peak threshold, a line per pose (Fig. 6)."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reports.figures.style import QUIET, as_label, legend_below, new_figure, series_styles, styled
from reports.method_order import order_methods

TICKS = 8
"""Thresholds that are all named on the axis; more are left to the axis."""


@styled
def diffusion_error_curves(table: pd.DataFrame) -> Figure:
    """Panels, one per operator (columns) and number of views (rows), of one dataset.

    Each has its own axis: operators differ in the size of their kernels, and their errors do not compare. A
    strip below each panel shows the missing surface.

    Parameters
    ----------
    table
        Rows of kind ``"stability"`` of one dataset: columns ``operator``, ``views``, ``source_pose``,
        ``source_threshold``, ``source_missing`` (share of the surface in [0, 1]) and ``eq18``. Several
        seeds or subjects are averaged; their range is shaded.
    """
    operators = order_methods(table["operator"])
    views = sorted(table["views"].unique())
    figure, grid = new_figure(
        2 * len(views),
        len(operators),
        3.5 * len(operators) + 1.0,
        3.5 * len(views) + 0.5,
        sharex=True,
        height_ratios=[3, 1] * len(views),
    )
    styles = series_styles(list(dict.fromkeys(table["source_pose"])))
    for row, strips, count in zip(grid[::2], grid[1::2], views, strict=True):
        for axes, strip, operator in zip(row, strips, operators, strict=True):
            part = table[(table["operator"] == operator) & (table["views"] == count)]
            _draw(axes, part, styles)
            suffix = f", {count} views" if len(views) > 1 else ""
            axes.set_title(f"{operator}{suffix}")
            axes.set_ylim(0, 1.06 * float(part["eq18"].max() or 1))
            _missing(strip, part)
        row[0].set_ylabel("diffusion error, Eq. 18")
        strips[0].set_ylabel("missing, %")
    thresholds = sorted(table["source_threshold"].unique())
    for axes in grid[-1]:
        if len(thresholds) <= TICKS:
            axes.set_xticks(thresholds, [f"{value:g}" for value in thresholds])
        axes.set_xlabel("peak threshold τ")
    handles, labels = grid[0][0].get_legend_handles_labels()
    legend_below(figure, handles, labels, "pose")
    return figure


def _draw(axes: Axes, part: pd.DataFrame, styles: dict[str, dict[str, Any]]) -> None:
    for pose, style in styles.items():
        of_pose = part[part["source_pose"] == pose].groupby("source_threshold")["eq18"]
        curve = of_pose.agg(["mean", "min", "max"])
        if curve.empty:
            continue
        axes.plot(curve.index, curve["mean"], label=as_label(pose), mec="white", mew=0.5, **style)
        if (curve["max"] > curve["min"]).any():
            axes.fill_between(curve.index, curve["min"], curve["max"], color=style["color"], alpha=0.13, lw=0)


def _missing(axes: Axes, part: pd.DataFrame) -> None:
    """Missing share: the mean over poses and their range."""
    share = 100 * part.groupby("source_threshold")["source_missing"].agg(["mean", "min", "max"])
    axes.fill_between(share.index, share["min"], share["max"], color=QUIET, alpha=0.25, lw=0)
    axes.plot(share.index, share["mean"], color=QUIET, lw=1.2, marker="")
    axes.set_ylim(0, max(50.0, 10 * np.ceil(float(share["max"].max() or 0) / 10)))

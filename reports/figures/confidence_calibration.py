"""Whether confidence means what it says: the share of right matches against their confidence."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from reports.figures.style import QUIET, as_label, legend_below, method_lines, new_figure, styled
from reports.method_order import order_methods

RIGHT = 5.0
"""Geodesic error, x 100 / sqrt(area), up to which a match is right."""
BINS = 10
LEAST = 30
"""Points of a bin that is drawn."""


def calibration_table(points: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]]) -> pd.DataFrame:
    """Share of right matches by confidence, in bins of equal width.

    Parameters
    ----------
    points
        By method: confidence in [0, 1] and error x 100 / sqrt(area) of all source points of all maps, each
        (n,); an error of nan is a point without a match, which is wrong.

    Returns
    -------
    DataFrame
        A row per method and bin with points: ``low``, ``high`` (ends of the bin), ``points``, ``confidence``
        (mean), ``right`` (share).
    """
    rows = []
    for method, (confidence, errors) in points.items():
        place = np.clip((confidence * BINS).astype(int), 0, BINS - 1)
        right = np.nan_to_num(errors, nan=np.inf) <= RIGHT
        for k in np.unique(place):
            some = place == k
            ends = {"low": k / BINS, "high": (k + 1) / BINS, "points": int(some.sum())}
            means = {"confidence": float(confidence[some].mean()), "right": float(right[some].mean())}
            rows.append({"method": method, **ends, **means})
    return pd.DataFrame(rows, columns=["method", "low", "high", "points", "confidence", "right"])


@styled
def confidence_calibration(table: pd.DataFrame) -> Figure:
    """Share of right matches against confidence, a line per method, and how many points each bin has.

    Parameters
    ----------
    table
        Of `calibration_table`. Bins of fewer than `LEAST` points are left out of the lines.
    """
    methods = order_methods(table["method"])
    styles = method_lines(methods)
    figure, grid = new_figure(2, 1, 4.2, 4.6, sharex=True, height_ratios=[3, 1])
    upper, lower = grid[:, 0]
    upper.plot([0, 1], [0, 100], color=QUIET, lw=1, ls=":", label="as sure as right")
    for number, method in enumerate(methods):
        part = table[table["method"] == method]
        drawn = part[part["points"] >= LEAST]
        upper.plot(drawn["confidence"], 100 * drawn["right"], "o", **styles[method], label=as_label(method))
        width = 0.8 / len(methods) / BINS
        places = part["low"] + 0.1 / BINS + (number + 0.5) * width
        lower.bar(places, 100 * part["points"] / part["points"].sum(), width, color=styles[method]["color"])
    upper.set_ylim(0, 102)
    upper.set_xlim(0, 1)
    upper.set_ylabel(f"right matches (error up to {RIGHT:g}), %")
    upper.set_title("calibration of confidence")
    lower.set_ylabel("points, %")
    lower.set_xlabel("confidence")
    legend_below(figure, *upper.get_legend_handles_labels())
    return figure

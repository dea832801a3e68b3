"""Error against missing surface: a dot per map, a line per method, a band over the seeds."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from reports.figures.style import as_label, legend_below, method_lines, new_figure, styled
from reports.method_order import order_methods

BAND = 40
"""Places along the axis at which the band over the seeds is drawn."""


@styled
def error_against_missing(table: pd.DataFrame) -> Figure:
    """Mean geodesic error of every pair against its missing surface, a panel per dataset.

    Parameters
    ----------
    table
        Rows of kind ``"matching"``: columns ``dataset``, ``method``, ``source_missing``, ``target_missing``
        (shares in [0, 1]) and ``geodesic_mean``; at least one of `scored_maps`. The line joins the medians
        of groups of equal size. With several seeds (column ``seed``), a band holds the lines that each seed
        gives by itself.
    """
    table = scored_maps(table)
    datasets = list(dict.fromkeys(table["dataset"]))
    methods = order_methods(table["method"])
    styles = method_lines(methods)
    columns = min(3, len(datasets))
    rows = -(-len(datasets) // columns)
    figure, grid = new_figure(rows, columns, 3.3 * columns + 0.6, 2.5 * rows + 0.6, sharey=True, sharex=True)
    for axes in list(grid.flat)[len(datasets) :]:
        axes.set_visible(False)
    for axes, dataset in zip(grid.flat, datasets, strict=False):
        for name in methods:
            part = table[(table["dataset"] == dataset) & (table["method"] == name)]
            missing = 50 * (part["source_missing"] + part["target_missing"]).to_numpy()
            error = part["geodesic_mean"].to_numpy()
            axes.plot(missing, error, ".", color=styles[name]["color"], alpha=0.7, markersize=8, mew=0)
            seeds = part["seed"].to_numpy() if "seed" in part else np.zeros(len(part), int)
            groups = groups_of(seeds)
            axes.plot(*_medians(missing, error, groups), **styles[name], label=as_label(name))
            if len(np.unique(seeds)) > 1 and groups > 1:
                band = seed_band(missing, error, seeds)
                if band[0][0] < band[0][-1]:  # else the seeds' lines have no place in common
                    axes.fill_between(*band, color=styles[name]["color"], alpha=0.15, lw=0)
        axes.set_title(dataset)
        axes.set_xlabel("missing surface, mean of both scans, %")
    grid[0][0].set_ylim(bottom=0)
    grid[0][0].set_xlim(left=0)
    for row in grid:
        row[0].set_ylabel("mean error × 100 / √area")
    handles, labels = grid[0][0].get_legend_handles_labels()
    legend_below(figure, handles, labels)
    return figure


def scored_maps(table: pd.DataFrame) -> pd.DataFrame:
    """Rows with a known error at a known missing share: what the figure can show."""
    wanted = ["source_missing", "target_missing", "geodesic_mean"]
    return table.dropna(subset=wanted) if set(wanted) <= set(table.columns) else table.iloc[:0]


def seed_band(
    missing: NDArray[np.float64], error: NDArray[np.float64], seeds: NDArray[np.integer]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Where the lines of single seeds lie.

    Parameters
    ----------
    missing, error, seeds : (maps,)

    Returns
    -------
    missing, low, high : (BAND,) float64
        Least and greatest value of the seeds' lines where all of them are defined.
    """
    groups = groups_of(seeds)
    lines = [_medians(missing[seeds == seed], error[seeds == seed], groups) for seed in np.unique(seeds)]
    start, end = max(x[0] for x, _ in lines), min(x[-1] for x, _ in lines)
    at = np.linspace(start, max(start, end), BAND)
    values = np.array([np.interp(at, *line) for line in lines])
    return at, values.min(axis=0), values.max(axis=0)


def groups_of(seeds: NDArray[np.integer]) -> int:
    """Groups along a line, for all seeds and for each alike: up to six, of two maps of a seed at least."""
    fewest = int(np.unique(seeds, return_counts=True)[1].min())
    return min(6, max(1, fewest // 2))


def _medians(x: NDArray[np.float64], y: NDArray[np.float64], count: int) -> tuple[list[float], list[float]]:
    """Medians of groups of equal size along x."""
    groups = np.array_split(np.argsort(x, kind="stable"), count)
    return [float(np.median(x[g])) for g in groups], [float(np.median(y[g])) for g in groups]

"""Seconds that operators and maps take against the number of points, a line per method."""

import pandas as pd
from matplotlib.figure import Figure

from reports.figures.style import as_label, legend_below, method_lines, new_figure, plain_numbers, styled
from reports.method_order import order_methods

WHAT = {"seconds_operator": "operators of both scans", "seconds_match": "match"}
"""Columns of the results table, and what was timed."""


def runtimes(maps: pd.DataFrame) -> pd.DataFrame:
    """Median, least and greatest time of every method at every number of points.

    Parameters
    ----------
    maps
        Rows of kind ``"matching"``: columns ``method``, ``n_points`` and those of `WHAT`.

    Returns
    -------
    DataFrame
        Columns ``what``, ``method``, ``n_points``, ``maps``, ``median``, ``low``, ``high`` in seconds; empty
        if nothing was timed.
    """
    names = ["what", "method", "n_points", "maps", "median", "low", "high"]
    parts = [pd.DataFrame(columns=names)]
    columns = {"count": "maps", "min": "low", "max": "high"}
    for column in [each for each in WHAT if each in maps]:
        grouped = maps.dropna(subset=[column]).groupby(["method", "n_points"], sort=True)[column]
        found = grouped.agg(["count", "median", "min", "max"]).reset_index()
        parts.append(found.rename(columns=columns).assign(what=column)[names])
    return pd.concat([part for part in parts if len(part)] or parts[:1], ignore_index=True)


@styled
def runtime_against_size(table: pd.DataFrame) -> Figure:
    """Times on logarithmic axes: medians, and whiskers from the least to the greatest.

    Parameters
    ----------
    table
        Of `runtimes`; at least one row.
    """
    shown = [what for what in WHAT if (table["what"] == what).any()]
    methods = order_methods(table["method"])
    styles = method_lines(methods)
    figure, grid = new_figure(1, len(shown), 3.2 * len(shown) + 0.4, 3.1)
    for axes, what in zip(grid[0], shown, strict=True):
        for number, method in enumerate(methods):
            part = table[(table["what"] == what) & (table["method"] == method)]
            aside = 1 + 0.02 * (number - (len(methods) - 1) / 2)  # whiskers side by side
            at, median = aside * part["n_points"].to_numpy(float), part["median"].to_numpy(float)
            spread = [median - part["low"].to_numpy(float), part["high"].to_numpy(float) - median]
            axes.errorbar(
                at, median, spread, marker="o", label=as_label(method), elinewidth=0.9, **styles[method]
            )
        axes.set_xscale("log")
        axes.set_yscale("log")
        sizes = sorted(table["n_points"].unique())
        axes.set_xticks(sizes, [f"{size:,}" for size in sizes])
        axes.minorticks_off()
        plain_numbers(axes.yaxis)
        axes.set_xlim(0.8 * sizes[0], 1.25 * sizes[-1])
        axes.set_title(WHAT[what])
        axes.set_xlabel("points of a scan")
        axes.set_ylabel("seconds")
    handles = {
        label: handle
        for axes in grid[0]
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    labels = [as_label(name) for name in methods if as_label(name) in handles]
    legend_below(figure, [handles[label] for label in labels], labels)
    return figure

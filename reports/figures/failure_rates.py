"""How often methods fail: maps that swap left and right, and maps that are grossly wrong."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.stats import binomtest

from reports.figures.style import as_label, method_colors, new_figure, styled
from reports.method_order import order_methods

KINDS = {"flipped": "left and right swapped", "gross": "gross failure"}
"""Columns of the results table, and what they mean."""
LEVEL = 0.95


def rates_of_failure(maps: pd.DataFrame) -> pd.DataFrame:
    """Share of maps that fail, with Wilson intervals.

    Parameters
    ----------
    maps
        Rows of kind ``"matching"``: columns ``dataset``, ``method``, and those of `KINDS` that there are;
        missing values, of bodies without a mirror map, do not count.

    Returns
    -------
    DataFrame
        A row per data set, method and kind: ``failed``, ``maps``, ``rate``, ``low``, ``high`` (in [0, 1]).
    """
    rows = []
    for (dataset, method), part in maps.groupby(["dataset", "method"], sort=False):
        for kind in [each for each in KINDS if each in part]:
            known = part[kind].dropna().astype(bool)
            if known.empty:
                continue
            failed, count = int(known.sum()), len(known)
            low, high = binomtest(failed, count).proportion_ci(LEVEL, "wilson")
            shares = {"rate": failed / count, "low": low, "high": high}
            about = {"dataset": dataset, "method": method, "kind": kind}
            rows.append({**about, "failed": failed, "maps": count, **shares})
    columns = ["dataset", "method", "kind", "failed", "maps", "rate", "low", "high"]
    return pd.DataFrame(rows, columns=columns)


@styled
def failure_rates(rates: pd.DataFrame) -> Figure:
    """Rates of failure: a row of panels per kind, a panel per data set, a bar per method.

    Parameters
    ----------
    rates
        Of `rates_of_failure`; at least one row. Whiskers are Wilson intervals, as if maps were independent.
    """
    datasets = list(dict.fromkeys(rates["dataset"]))
    kinds = [kind for kind in KINDS if (rates["kind"] == kind).any()]
    methods = order_methods(rates["method"])[::-1]
    colors = method_colors(methods)
    tall = 0.24 * len(methods) + 0.75
    figure, grid = new_figure(
        len(kinds),
        len(datasets),
        2.6 * len(datasets) + 1.6,
        tall * len(kinds) + 0.2,
        sharey=True,
        sharex=True,
    )
    for row, kind in zip(grid, kinds, strict=True):
        for axes, dataset in zip(row, datasets, strict=True):
            part = rates[(rates["dataset"] == dataset) & (rates["kind"] == kind)].set_index("method")
            for place, method in enumerate(methods):
                if method not in part.index:
                    continue
                each = 100 * part.loc[method, ["rate", "low", "high"]].to_numpy(float)
                axes.barh(place, each[0], color=colors[method], height=0.66)
                axes.plot(each[1:], [place, place], color="#24292f", lw=0.9)
                share = f"{part.loc[method, 'failed']} of {part.loc[method, 'maps']}"
                axes.text(each[2] + 1.5, place, share, va="center", fontsize=7)
            axes.set_title(f"{dataset}: {KINDS[kind]}")
            axes.set_yticks(np.arange(len(methods)), [as_label(method) for method in methods])
            axes.grid(False, axis="y")
            axes.set_xlim(0, 118)
            axes.set_xticks([0, 25, 50, 75, 100])
            if kind == kinds[-1]:
                axes.set_xlabel("maps, % (whiskers: 95 % intervals)")
    return figure

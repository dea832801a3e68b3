"""Comparisons of methods on the same pairs of scans."""

import itertools

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from reports.tables.completeness import unmatched

PAIR = ["dataset", "regime", "source_pose", "target_pose"]
"""What makes two maps comparable; seeds of one pair are averaged, since they are no independent pairs."""


def paired_tests(table: pd.DataFrame, measure: str = "geodesic_mean") -> pd.DataFrame:
    """For every two methods, whether one has the lower error on the pairs for which both have a map.

    Methods whose maps leave points out are not compared (`reports.tables.completeness.unmatched`).

    The Wilcoxon signed-rank test is two-sided and asks nothing of the errors' distribution; its p-values are
    corrected for the number of comparisons by Holm's method.

    Parameters
    ----------
    table
        Of `reports.tables.leaderboard.with_numpy_types`.
    measure
        Column to compare; lower is better.

    Returns
    -------
    DataFrame
        ``first``, ``second`` (the lower median difference first), ``pairs``, ``difference`` (median of second
        minus first), ``wins`` (share of pairs on which the first is lower), ``p`` (corrected; nan where there
        are fewer than 6 pairs that differ).
    """
    maps = table[table["kind"] == "matching"]
    maps = maps[~maps["method"].isin(list(unmatched(maps)))]
    values = pd.to_numeric(maps[measure], errors="coerce")
    wide = maps.assign(value=values).pivot_table("value", PAIR, "method", aggfunc="mean", dropna=False)
    rows = []
    for a, b in itertools.combinations([str(name) for name in wide.columns], 2):
        gap = (wide[b] - wide[a]).dropna().to_numpy()
        if not len(gap):
            continue
        first, second, gap = (a, b, gap) if np.median(gap) >= 0 else (b, a, -gap)
        rows.append(
            (first, second, len(gap), float(np.median(gap)), float((gap > 0).mean()), signed_rank(gap))
        )
    result = pd.DataFrame(rows, columns=["first", "second", "pairs", "difference", "wins", "p"])
    result["p"] = holm(result["p"].to_numpy(float))
    return result.sort_values("difference", ascending=False, kind="stable").reset_index(drop=True)


def signed_rank(gaps: NDArray[np.float64]) -> float:
    """Two-sided p-value of the Wilcoxon signed-rank test; nan for fewer than 6 gaps that are not 0."""
    from scipy.stats import wilcoxon

    gaps = gaps[gaps != 0]
    return float(wilcoxon(gaps).pvalue) if len(gaps) >= 6 else float("nan")


def holm(p: NDArray[np.float64]) -> NDArray[np.float64]:
    """Holm-Bonferroni correction; nan stays nan and is not counted."""
    corrected = np.full(len(p), np.nan)
    there = np.flatnonzero(~np.isnan(p))
    order = there[np.argsort(p[there], kind="stable")]
    steps = p[order] * np.arange(len(order), 0, -1)
    corrected[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return corrected

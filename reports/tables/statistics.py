"""Comparisons of methods on the same pairs of poses, under the same regimes and seeds."""

import itertools
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from reports.tables.completeness import unmatched
from reports.tables.nested_bootstrap import bootstrap_interval, nested_weights, resampled_weights

UNIT = ["dataset", "source_pose", "target_pose"]
"""What makes two maps comparable and independent of others: a pair of poses."""
NESTED = ["regime", "seed"]
"""What is nested in a pair of poses: maps that differ in these alone are no independent pairs."""
TIE = 0.05
"""Differences below this, half of the last digit that tables show, are ties."""
FEWEST = 6
"""Pairs of poses from which a signed-rank test can reach p < .05; fewer decide nothing."""
COLUMNS = ("first", "second", "pairs", "difference", "low", "high", "wins", "ties", "p")

Float = NDArray[np.float64]


def paired_tests(table: pd.DataFrame, measure: str = "geodesic_mean") -> pd.DataFrame:
    """For every two methods, how much lower one error is, on the maps that both have.

    The unit is the pair of poses; regimes and seeds are nested in it
    (`reports.tables.nested_bootstrap`). Methods whose maps leave points out are not compared
    (`reports.tables.completeness.unmatched`). The Wilcoxon signed-rank test over pairs of poses is two-sided
    and asks nothing of the errors' distribution; its p-values are corrected for the number of comparisons by
    Holm's method.

    Parameters
    ----------
    table
        Of `reports.tables.leaderboard.with_numpy_types`.
    measure
        Column to compare; lower is better.

    Returns
    -------
    DataFrame
        ``first``, ``second`` (the one with the lower mean first), ``pairs`` of poses, ``difference`` (second
        minus first, mean over pairs) with ``low`` and ``high`` of its 95 % interval (nan for one pair),
        ``wins`` (pairs on which the first is lower), ``ties`` (pairs that differ by less than `TIE`), ``p``
        (corrected; nan where there are fewer than `FEWEST` pairs that differ).
    """
    maps = table[table["kind"] == "matching"]
    maps = maps[~maps["method"].isin(list(unmatched(maps)))]
    wide = _by_method(maps, measure)
    rows = []
    for a, b in itertools.combinations([str(name) for name in wide.columns], 2):
        gap = (wide[b] - wide[a]).dropna()
        if len(gap):
            rows.append(_compared(a, b, gap))
    result = pd.DataFrame(rows, columns=list(COLUMNS))
    result["p"] = holm(result["p"].to_numpy(float))
    return result.sort_values("difference", ascending=False, kind="stable").reset_index(drop=True)


def _compared(
    a: str, b: str, gap: "pd.Series[float]"
) -> tuple[str, str, int, float, float, float, int, int, float]:
    """A row of `paired_tests` from the gaps of all maps, b minus a."""
    cells = _cells(gap.index)
    by_pair = unit_means(cells, gap.to_numpy(np.float64))
    if by_pair.mean() < 0:
        a, b, gap, by_pair = b, a, -gap, -by_pair
    mean, values = float(by_pair.mean()), gap.to_numpy(np.float64)
    low, high = bootstrap_interval(mean, resampled_weights(cells) @ values, len(by_pair))
    tied = np.abs(by_pair) < TIE
    wins = int((by_pair[~tied] > 0).sum())
    return a, b, len(by_pair), mean, low, high, wins, int(tied.sum()), signed_rank(by_pair)


def nested_mean(maps: pd.DataFrame, measure: str) -> float:
    """Mean over pairs of poses of the means over their regimes, of the means over seeds; nan for no value.

    A column that `maps` lacks, as tables of earlier versions do, holds no value.
    """
    if measure not in maps:
        return float("nan")
    values = pd.to_numeric(maps[measure], errors="coerce").to_numpy(np.float64, na_value=np.nan)
    there = ~np.isnan(values)
    if not there.any():
        return float("nan")
    cells = _cells(pd.MultiIndex.from_frame(maps.loc[there, [*UNIT, *NESTED]]))
    return float(nested_weights(cells) @ values[there])


def unit_means(cells: pd.DataFrame, values: Float) -> Float:
    """Mean of each pair of poses over its regimes, of their means over seeds: (pairs,)."""
    weights = nested_weights(cells)
    units = cells["unit"].to_numpy()
    total = np.bincount(units, weights * values)
    return total / np.bincount(units, weights)


def unbeaten(maps: pd.DataFrame, measures: dict[str, tuple[str, bool]]) -> dict[str, set[str]]:
    """Methods of a group that nothing beats beyond noise, by measure; none where they are all alike.

    A method is beaten where the 95 % interval of its paired difference to the one with the best mean excludes
    0. With fewer than `FEWEST` pairs of poses none is beaten: such an interval says more of how few they are
    than of the methods.

    Parameters
    ----------
    maps
        Rows of one group, of the methods that compete.
    measures
        Column of `maps` and whether lower is better, by name of the measure.

    Returns
    -------
    dict of str to set of str
    """
    found: dict[str, set[str]] = {}
    known: dict[tuple[int, ...], _Resamples] = {}
    for name, (column, low_is_better) in measures.items():
        wide = _by_method(maps, column)
        wide = wide.loc[:, wide.notna().any()]
        if not low_is_better:
            wide = -wide
        if wide.shape[1] < 2:
            continue
        best = wide.mean().idxmin()
        beaten = {str(other) for other in wide.columns.drop(best) if _beaten(wide[other] - wide[best], known)}
        if beaten:
            found[name] = {str(method) for method in wide.columns} - beaten
    return found


class _Resamples(NamedTuple):
    """Of some maps: the number of pairs of poses, and the weights of their mean and of its resamples."""

    units: int
    weights: Float
    drawn: Float


def _beaten(gap: "pd.Series[float]", known: dict[tuple[int, ...], _Resamples]) -> bool:
    """Whether gaps are above 0 beyond noise; `known` keeps the resamples of the same maps."""
    there = np.flatnonzero(gap.notna())
    if not len(there):
        return False
    key, values = tuple(there.tolist()), gap.to_numpy(np.float64)[there]
    if key not in known:
        cells = _cells(gap.index[there])
        known[key] = _Resamples(cells["unit"].nunique(), nested_weights(cells), resampled_weights(cells))
    units, weights, drawn = known[key]
    return units >= FEWEST and bootstrap_interval(float(weights @ values), drawn @ values, units)[0] > 0


def _by_method(maps: pd.DataFrame, measure: str) -> pd.DataFrame:
    """Values by pair of poses, regime and seed (rows) and method (columns)."""
    values = pd.to_numeric(maps[measure].astype("object"), errors="coerce")
    groups = maps.assign(value=values).groupby([*UNIT, *NESTED, "method"], dropna=False, observed=True)
    return groups["value"].mean().unstack("method")


def _cells(index: pd.Index) -> pd.DataFrame:
    """Units, regimes and seeds of values as small whole numbers, for `nested_weights`."""
    frame = index.to_frame(index=False)
    unit = frame.groupby(UNIT, sort=False, dropna=False).ngroup()
    inner = {name: pd.factorize(frame[name])[0] for name in NESTED}
    return pd.DataFrame({"unit": unit.to_numpy(), **inner})


def signed_rank(gaps: NDArray[np.float64]) -> float:
    """Two-sided p-value of the Wilcoxon signed-rank test; nan for fewer than `FEWEST` gaps that are not 0."""
    from scipy.stats import wilcoxon

    gaps = gaps[gaps != 0]
    return float(wilcoxon(gaps).pvalue) if len(gaps) >= FEWEST else float("nan")


def holm(p: NDArray[np.float64]) -> NDArray[np.float64]:
    """Holm-Bonferroni correction; nan stays nan and is not counted."""
    corrected = np.full(len(p), np.nan)
    there = np.flatnonzero(~np.isnan(p))
    order = there[np.argsort(p[there], kind="stable")]
    steps = p[order] * np.arange(len(order), 0, -1)
    corrected[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return corrected

"""Means of a results table: the leaderboard of the methods, and Eq. 18 by threshold."""

from collections.abc import Collection, Mapping
from contextlib import suppress
from typing import Any

import numpy as np
import pandas as pd

from reports.method_order import order_methods
from reports.tables.columns import GROUP, LEADERBOARD, NOTE, PARTIAL, STABILITY, UNBEATEN
from reports.tables.completeness import unranked
from reports.tables.statistics import unbeaten

LITTLE_SHARED = 0.9
"""Share of source points with a counterpart below which a regime's scans share little surface."""


RATES = {"flip_rate": "flipped", "gross_rate": "gross"}
"""Columns in per cent of the maps, and the truth values that they count."""
MEASURES = {c.name: (RATES.get(c.name, c.name), c.best == "low") for c in LEADERBOARD if c.best}
"""What methods are compared in: the column of the results table, and whether lower is better."""


def with_numpy_types(table: pd.DataFrame) -> pd.DataFrame:
    """The results table in NumPy types: no number is nan, truth values are 0, 1 or nan, no text is None."""
    result = table.copy()
    for name, kind in table.dtypes.items():
        if pd.api.types.is_integer_dtype(kind) and not table[name].isna().any():
            result[name] = table[name].to_numpy(np.int64)
        elif pd.api.types.is_numeric_dtype(kind) or pd.api.types.is_bool_dtype(kind):
            result[name] = table[name].to_numpy(np.float64, na_value=np.nan)
        else:
            result[name] = table[name].astype(object).where(table[name].notna(), None)
    return result


def ceilings(settings: Mapping[str, Any]) -> set[str]:
    """Labels of the methods of an experiment that look at the ground truth: no competitors.

    Parameters
    ----------
    settings
        Of `evaluation.ResultsStore.settings`.
    """
    from evaluation.methods import find

    found = set()
    for method in settings.get("method", []):
        with suppress(Exception):  # a method of the user's that is no longer there competes
            if find(method["name"]).uses_truth:
                found.add(str(method.get("label", method["name"])))
    return found


def leaderboard(table: pd.DataFrame, beyond: Collection[str] = ()) -> pd.DataFrame:
    """Means per data set, regime and method, the best mean error first within each group.

    Methods with incomplete maps come after the others (`reports.tables.completeness`).

    Parameters
    ----------
    table
        Of `with_numpy_types`.
    beyond
        Methods that do not compete, of `ceilings`; they come last and are never the best.

    Returns
    -------
    DataFrame
        Columns of `LEADERBOARD`, of which `NOTE` says why a method is not ranked, ``beyond`` and `UNBEATEN`;
        empty if nothing was matched. Those of `PARTIAL` are nan for regimes under which more than
        `LITTLE_SHARED` of the source has a counterpart.
    """
    maps = _numeric(table[table["kind"] == "matching"])
    if maps.empty:
        return pd.DataFrame(columns=[column.name for column in LEADERBOARD])
    maps["missing"] = 50 * (maps["source_missing"] + maps["target_missing"])
    for name, source in RATES.items():
        maps[name] = 100 * pd.to_numeric(maps[source].astype("object"), errors="coerce")
    maps["eq18"] = _operator_error(maps, _numeric(table[table["kind"] == "stability"]))
    grouped = maps.groupby([*GROUP, "method"], sort=False)
    means = grouped[[c.name for c in LEADERBOARD if c.name in maps and c.digits is not None]].mean()
    means["matched"] *= 100
    means["maps"] = grouped.size()
    by_seed = maps.groupby([*GROUP, "method", "seed"], sort=False)["geodesic_mean"].mean()
    means["spread"] = by_seed.groupby([*GROUP, "method"], sort=False).std()
    result = means.reset_index()
    groups = pd.MultiIndex.from_frame(result[GROUP])
    little = share_little(maps).reindex(groups, fill_value=False).to_numpy()
    result.loc[~little, list(PARTIAL)] = np.nan
    place = {key: i for i, key in enumerate(dict.fromkeys(zip(maps["dataset"], maps["regime"], strict=True)))}
    rank = [place[key] for key in zip(result["dataset"], result["regime"], strict=True)]
    reasons = {key: unranked(rows) for key, rows in maps.groupby(GROUP, sort=False)}
    notes = [
        reasons[row[:2]].get(row[2]) for row in result[[*GROUP, "method"]].itertuples(index=False, name=None)
    ]
    result = result.assign(_rank=rank, beyond=result["method"].isin(list(beyond)))
    result[NOTE] = pd.Series(notes, index=result.index, dtype=object)
    result[UNBEATEN] = _unbeaten(maps, result)
    result["_last"] = result[NOTE].notna()
    result = result.sort_values(["_rank", "beyond", "_last", "geodesic_mean"], kind="stable")
    shown = [c.name for c in LEADERBOARD if c.name in result]
    return result[[*shown, "beyond", UNBEATEN]].reset_index(drop=True)


def share_little(maps: pd.DataFrame) -> "pd.Series[bool]":
    """For each group of a table, whether its scans share little surface, `LITTLE_SHARED`."""
    overlap = pd.to_numeric(maps["overlap"], errors="coerce")
    return overlap.groupby([maps[name] for name in GROUP]).mean() < LITTLE_SHARED


def _unbeaten(maps: pd.DataFrame, board: pd.DataFrame) -> "pd.Series[object]":
    """For each row of a leaderboard the measures in which nothing beats its method beyond noise."""
    rivals = board[~board["beyond"] & board[NOTE].isna()]
    groups = dict(iter(maps.groupby(GROUP, sort=False)))
    found = pd.Series([frozenset[str]() for _ in board.index], index=board.index, dtype=object)
    for key, rows in rivals.groupby(GROUP, sort=False):
        group = groups[key]
        best = unbeaten(group[group["method"].isin(rows["method"])], MEASURES)
        for i, method in rows["method"].items():
            found[i] = frozenset(name for name, methods in best.items() if method in methods)
    return found


def stability_table(table: pd.DataFrame) -> pd.DataFrame:
    """Mean errors of Eq. 18 per data set, operator, number of views and threshold; columns of `STABILITY`."""
    rows = _numeric(table[(table["kind"] == "stability") & table["source_threshold"].notna()])
    keys = ["dataset", "operator", "views", "source_threshold"]
    if rows.empty:
        return pd.DataFrame(columns=[column.name for column in STABILITY])
    rows["missing"] = 100 * rows["source_missing"]
    grouped = rows.groupby(keys, sort=False, dropna=False)
    values = [c.name for c in STABILITY if c.name in rows and c.name not in keys]
    result = grouped[values].mean().assign(scans=grouped.size()).reset_index()
    place = {name: i for i, name in enumerate(order_methods(result["operator"]))}
    result = result.sort_values(
        keys, key=lambda s: s.map(place) if s.name == "operator" else s, kind="stable"
    )
    return result[[c.name for c in STABILITY if c.name in result]].reset_index(drop=True)


def _numeric(rows: pd.DataFrame) -> pd.DataFrame:
    """A copy in which every measured column is a float; columns a run lacks are nan."""
    rows = rows.copy()
    measured = {c.name for c in (*LEADERBOARD, *STABILITY) if c.digits is not None}
    for name in (measured - {"maps", "missing", "spread", "scans", *RATES}) | {
        "source_missing",
        "target_missing",
        "overlap",
    }:
        rows[name] = pd.to_numeric(rows[name], errors="coerce") if name in rows else np.nan
    for name in RATES.values():
        if name not in rows:
            rows[name] = None
    return rows


def _operator_error(maps: pd.DataFrame, stable: pd.DataFrame) -> pd.Series:
    """Eq. 18 of each map's operator at its source's threshold and views, mean over poses; nan if unknown."""
    keys = ["dataset", "operator", "source_threshold", "views"]
    mean = stable.groupby(keys)["eq18"].mean() if not stable.empty else pd.Series(dtype=float)
    found = [mean.get(tuple(row), np.nan) for row in maps[keys].itertuples(index=False)]
    return pd.Series(found, index=maps.index, dtype=float)

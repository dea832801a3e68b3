"""What the scripts of the page read: one row per map, mean curves, and rows of Eq. 18, as JSON."""

import json
import math
from collections.abc import Collection, Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from evaluation.metrics.correspondence import CURVE
from evaluation.results.store import ResultsStore
from reports.figures.style import method_colors
from reports.method_order import order_methods
from reports.tables.columns import GROUP, LEADERBOARD
from reports.tables.completeness import unmatched
from reports.tables.leaderboard import MEASURES, RATES, share_little
from reports.tables.statistics import FEWEST, unbeaten

KEYS = ("dataset", "regime", "source_pose", "target_pose", "seed", "method")
DIGITS = 5
"""Significant digits of numbers in the page; tables show at most four."""
DERIVED = ("maps", "missing", "spread", "eq18")
"""Columns of the leaderboard that are no column of the results table."""


def page_json(
    store: ResultsStore, table: pd.DataFrame, beyond: Collection[str], pictures: Mapping[str, str]
) -> str:
    """Rows, methods, measures, curves and Eq. 18 for the scripts of the page.

    Parameters
    ----------
    store, table
        A results folder and its table, of `reports.tables.leaderboard.with_numpy_types`.
    beyond
        Methods that do not compete.
    pictures
        Name of the picture of a pair of scans, by `pair_key`.

    Returns
    -------
    str
        JSON without ``<``, ``>`` or ``&``, so that it can stand in a script element.
    """
    maps = table[table["kind"] == "matching"]
    colors = method_colors(maps["method"]) if len(maps) else {}
    partial = unmatched(maps)
    found = {
        "measures": [
            {"name": c.name, "title": c.title, "digits": c.digits, "best": c.best, "about": c.about}
            for c in LEADERBOARD
            if c.digits is not None and c.name not in DERIVED
        ],
        "methods": [
            {"name": name, "color": colors[name], "beyond": name in beyond, "note": partial.get(name, "")}
            for name in order_methods(maps["method"])
        ],
        "rows": _columns(maps, pictures),
        "partial": _shown_of_partial(maps),
        "fewest": FEWEST,
        "unbeaten": list(_unbeaten(maps, {*beyond, *partial})),
        "pck": {"radii": [_short(100 * radius) for radius in CURVE], "curves": list(_curves(store, maps))},
        "stability": _stability(table),
    }
    text = json.dumps(found, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _shown_of_partial(maps: pd.DataFrame) -> list[str]:
    """Columns that are shown at first because the scans of some regime share little surface."""
    little = "overlap" in maps and share_little(maps).any()
    return ["oracle_mean", "right_limb", "probability"] if little else []


def pair_key(row: Mapping[str, Any]) -> str:
    """What names a pair of scans: both of its scans."""
    return f"{row['source_scan']} {row['target_scan']}"


def mean_curves(store: ResultsStore, maps: pd.DataFrame) -> dict[tuple[str, str], NDArray[np.float64]]:
    """Share of points matched within each radius of `CURVE`, mean over maps, by regime and method."""
    curves = {}
    for (regime, method), rows in maps.groupby(["regime", "method"], sort=False):
        stack = [store.score(str(key))["curve"] for key in rows["score_key"]]
        curves[str(regime), str(method)] = np.mean(stack, axis=0)
    return curves


def _columns(maps: pd.DataFrame, pictures: Mapping[str, str]) -> dict[str, list[Any]]:
    """Columns of the results table, by name; numbers that are not finite are null."""
    found: dict[str, list[Any]] = {name: maps[name].astype(object).tolist() for name in KEYS}
    for column in LEADERBOARD:
        name = RATES.get(column.name, column.name)
        if column.digits is not None and column.name not in DERIVED and name in maps:
            values = pd.to_numeric(maps[name].astype("object"), errors="coerce")
            scale = 100.0 if column.name in RATES or column.name == "matched" else 1.0
            found[column.name] = [_short(scale * value) for value in values]
    sides = maps[["source_missing", "target_missing"]].astype(float).mean(axis=1)
    found["missing"] = [_short(100 * value) for value in sides]
    found["picture"] = [pictures.get(pair_key(row), "") for row in maps.to_dict("records")]
    return found


def _unbeaten(maps: pd.DataFrame, aside: Collection[str]) -> Iterable[dict[str, Any]]:
    """Which methods nothing beats beyond noise, for each choice of data set and regime; "" is all of them."""
    rivals = maps[~maps["method"].isin(list(aside))]
    measures = {name: way for name, way in MEASURES.items() if way[0] in maps}
    choices = {(dataset, regime) for dataset, regime in rivals[GROUP].itertuples(index=False, name=None)}
    choices |= (
        {(dataset, "") for dataset, _ in choices} | {("", regime) for _, regime in choices} | {("", "")}
    )
    for dataset, regime in sorted(choices):
        part = rivals[rivals["dataset"] == dataset] if dataset else rivals
        part = part[part["regime"] == regime] if regime else part
        best = unbeaten(part, measures)
        yield {"dataset": dataset, "regime": regime, "best": {name: sorted(best[name]) for name in best}}


def _curves(store: ResultsStore, maps: pd.DataFrame) -> Iterable[dict[str, Any]]:
    for dataset, rows in maps.groupby("dataset", sort=False):
        for (regime, method), curve in mean_curves(store, rows).items():
            values = [_short(value) for value in curve]
            yield {"dataset": dataset, "regime": regime, "method": method, "values": values}


def _stability(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Rows of Eq. 18: pose, threshold, the error relative to the reference's kernel, and what is missing."""
    rows = table[(table["kind"] == "stability") & table["source_threshold"].notna()]
    return [
        {
            "dataset": row["dataset"],
            "operator": row["operator"],
            "views": row["views"],
            "pose": row["source_pose"],
            "seed": int(row["seed"]),
            "threshold": _short(row["source_threshold"]),
            "error": _short(row["eq18_relative"]),
            "missing": _short(100 * row["source_missing"]),
        }
        for row in rows.to_dict("records")
    ]


def _short(value: Any) -> float | None:
    """A number with `DIGITS` significant digits; None if it is not finite."""
    number = float(value)
    return float(f"{number:.{DIGITS}g}") if math.isfinite(number) else None

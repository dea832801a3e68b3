"""The main result of a run: methods by mean error, and what the first is worth in one sentence."""

import math
from collections.abc import Collection
from typing import Any

import pandas as pd

from datasets_gen.clouds.point_cloud import counted
from reports.method_order import order_methods
from reports.tables.columns import interval_text
from reports.tables.completeness import unranked
from reports.tables.statistics import FEWEST, nested_mean, paired_tests

LEAST_P = 0.0001
"""p-values below this are not spelled out."""


def overall(table: pd.DataFrame, beyond: Collection[str] = ()) -> list[dict[str, Any]]:
    """Means of each method over pairs of poses, the lowest error first.

    Those with incomplete maps come after the others, those beyond competition last.

    Parameters
    ----------
    table
        Of `reports.tables.leaderboard.with_numpy_types`.
    beyond
        Methods that do not compete.
    """
    maps = table[table["kind"] == "matching"]
    rows, notes = [], unranked(maps)
    for method in order_methods(maps["method"]):
        part = maps[maps["method"] == method]
        flips = part["flipped"].astype(float) if "flipped" in part else pd.Series(dtype=float)
        rows.append(
            {
                "method": method,
                "mean": nested_mean(part, "geodesic_mean"),
                "median": nested_mean(part, "geodesic_median"),
                "auc": nested_mean(part, "pck_auc"),
                "flips": None if flips.isna().all() else 100 * float(flips.mean()),
                "maps": len(part),
                "matched": 100 * float(part["matched"].mean()) if "matched" in part else float("nan"),
                "beyond": method in beyond,
                "note": notes.get(method, ""),
            }
        )
    return sorted(
        rows, key=lambda row: (row["beyond"], row["note"] != "", math.isnan(row["mean"]), row["mean"])
    )


def headline(table: pd.DataFrame, beyond: Collection[str] = ()) -> str:
    """The main result in one sentence; empty if fewer than two methods compete with complete, scored maps.

    The numbers are those of `reports.tables.statistics.paired_tests`, which ``medialbench compare`` prints.
    """
    matching = table[table["kind"] == "matching"]
    table = table[~table["method"].isin([*beyond, *unranked(matching)])]
    ranking = [row for row in overall(table) if not math.isnan(row["mean"])]
    names = {str(row["method"]) for row in ranking[:2]}
    tests = paired_tests(table).to_dict("records") if len(names) == 2 else []
    test = next((row for row in tests if {row["first"], row["second"]} == names), None)
    if test is None:
        return ""
    first, second = test["first"], test["second"]
    mean = {str(row["method"]): f"{row['mean']:.1f}" for row in ranking}
    pairs = counted(test["pairs"], "pair of poses", "pairs of poses")
    if test["pairs"] == 1:
        return (
            f"On one pair of poses, {first} has a mean geodesic error of {mean[first]} and {second} of "
            f"{mean[second]} (× 100 / √area); one pair tells nothing of others."
        )
    interval = f"95 % interval {interval_text(test['low'], test['high'])}{_p_text(test['p'])}"
    counts = f"lower on {test['wins']}, tied on {test['ties']} of {pairs}"
    if test["pairs"] < FEWEST:
        return (
            f"{pairs[0].upper()}{pairs[1:]} are too few to rank {first} and {second}: mean geodesic errors "
            f"{mean[first]} and {mean[second]} (× 100 / √area), difference {test['difference']:.2f} "
            f"({interval}); the first is {counts}."
        )
    if not test["low"] > 0:
        return (
            f"No difference beyond noise between {first} and {second}: mean geodesic errors {mean[first]} "
            f"and {mean[second]} (× 100 / √area), difference {test['difference']:.2f} ({interval}); "
            f"the first is {counts}."
        )
    return (
        f"The lowest mean geodesic error is that of {first}, {mean[first]} (× 100 / √area), ahead of "
        f"{second} with {mean[second]}: a difference of {test['difference']:.2f} ({interval}), {counts}."
    )


def _p_text(p: float) -> str:
    if p != p:
        return ""
    return f", p < {LEAST_P}" if p < LEAST_P else f", p = {p:.2g}"

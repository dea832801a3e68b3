"""The results table: one row per score, merged from the stored results."""

import logging
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from evaluation.experiment.plan import Plan
from evaluation.results.origin import Origin, write_csv, write_parquet
from evaluation.results.outcome import Outcome
from evaluation.results.store import ResultsStore

if TYPE_CHECKING:
    import pandas as pd

log = logging.getLogger(__name__)

COLUMNS: dict[str, str] = {
    "kind": "string",
    "dataset": "string",
    "subject": "string",
    "method": "string",
    "operator": "string",
    "source_pose": "string",
    "source_threshold": "Float64",
    "target_pose": "string",
    "target_threshold": "Float64",
    "regime": "string",
    "views": "string",
    "target_views": "string",
    "n_points": "Int64",
    "seed": "Int64",
    "source_missing": "Float64",
    "target_missing": "Float64",
    "eq18": "Float64",
    "eq18_trace": "Float64",
    "eq18_relative": "Float64",
    "matched": "Float64",
    "geodesic_mean": "Float64",
    "geodesic_median": "Float64",
    "geodesic_symmetric_mean": "Float64",
    "geodesic_overlap": "Float64",
    "geodesic_best": "Float64",
    "oracle_mean": "Float64",
    "excess_mean": "Float64",
    "gross": "boolean",
    "flipped": "boolean",
    "right_limb": "Float64",
    "mirror_limb": "Float64",
    "probability": "Float64",
    "alternatives": "Int64",
    "mirror_check": "string",
    "pck_auc": "Float64",
    "pck_01": "Float64",
    "pck_02": "Float64",
    "pck_05": "Float64",
    "pck_10": "Float64",
    "pck_20": "Float64",
    "medial_mean": "Float64",
    "medial_path_mean": "Float64",
    "coverage": "Float64",
    "error_confident": "Float64",
    "sure_right": "Float64",
    "overlap": "Float64",
    "overlap_iou": "Float64",
    "distinct": "Float64",
    "seconds_operator": "Float64",
    "seconds_match": "Float64",
    "peak_memory_mb": "Float64",
    "source_scan": "string",
    "target_scan": "string",
    "source_operator": "string",
    "map_key": "string",
    "score_key": "string",
}
"""Columns and their types. Lengths are in sqrt(area of the reference), times 100; shares are in [0, 1]."""


def write_tables(
    store: ResultsStore, plan: Plan, failures: Iterable[Outcome], origin: Origin
) -> "pd.DataFrame":
    """Write ``table.parquet``, ``table.csv`` and ``failures.csv``; rows are in the order of the plan.

    Parameters
    ----------
    store
    plan
        Rows without a stored score are left out.
    failures
        Tasks without a result.
    origin
        Written into each file.

    Returns
    -------
    DataFrame
        The table: `COLUMNS`, with their types.
    """
    import pandas as pd

    rows = [found for row in plan.rows if (found := _row(store, plan, row.columns, row.score)) is not None]
    table = pd.DataFrame(rows, columns=list(COLUMNS)).astype(COLUMNS)
    write_parquet(table, store.folder / "table.parquet", origin)
    write_csv(table, store.folder / "table.csv", origin)
    lines = [
        {
            "key": each.task.key,
            "stage": each.task.stage,
            "label": each.task.label,
            "kind": each.kind,
            "reason": each.reason,
        }
        for each in failures
    ]
    failed = pd.DataFrame(lines, columns=["key", "stage", "label", "kind", "reason"])
    write_csv(failed, store.folder / "failures.csv", origin)
    return table


def _row(store: ResultsStore, plan: Plan, columns: Mapping[str, Any], score: str) -> dict[str, Any] | None:
    """One row: what it is about, what was found, and what it took."""
    record = store.record("score", score)
    if record is None:
        return None
    return {**columns, **record["info"]["row"], **_cost(store, plan, columns)}


def _cost(store: ResultsStore, plan: Plan, columns: Mapping[str, Any]) -> dict[str, Any]:
    """Seconds and peak memory of the operators and of the map behind a row."""
    operators = [columns["source_operator"]] if columns.get("source_operator") else []
    found: dict[str, Any] = {}
    peaks = []
    if columns.get("map_key"):
        task = plan.tasks[columns["map_key"]]
        operators = [
            key
            for role, key in task.inputs.items()
            if key in plan.tasks and role.startswith(("source_", "target_"))
        ]
        operators = [key for key in operators if plan.tasks[key].stage == "operator"]
        record = store.record("map", task.key)
        if record is not None:
            found["seconds_match"] = record["seconds"]
            peaks.append(record["peak_memory_mb"])
    records = [r for key in operators if (r := store.record("operator", key)) is not None]
    if records:
        found["seconds_operator"] = sum(r["seconds"] for r in records)
    known = [peak for peak in (*peaks, *(r["peak_memory_mb"] for r in records)) if peak is not None]
    return found | ({"peak_memory_mb": max(known)} if known else {})

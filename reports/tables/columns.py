"""Columns of the tables: their heads, digits and meaning, and how a cell is shown."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd

from evaluation.results.outcome import printable

GROUP = ["dataset", "regime"]
NOTE = "note"
"""Column that says why a row does not compete; empty where it does."""
UNBEATEN = "unbeaten"
"""Column with the names of the columns in which nothing beats the row beyond noise; it is not shown."""
STABILITY_GROUP = ["dataset", "views", "source_threshold"]


@dataclass(frozen=True)
class Column:
    """How a column is shown.

    Attributes
    ----------
    name : str
        In the table.
    title : str
        Head of the column.
    digits : int or None
        After the point; None for text.
    best : str
        Which end is the better one: ``"low"``, ``"high"`` or ``""``.
    about : str
        One sentence for the reader.
    """

    name: str
    title: str
    digits: int | None = None
    best: Literal["low", "high", ""] = ""
    about: str = ""


LEADERBOARD = (
    Column("dataset", "data set"),
    Column("regime", "regime"),
    Column("method", "method"),
    Column("maps", "maps", 0, about="Pairs of scans, over all seeds."),
    Column("missing", "missing %", 0, about="Surface that the scans lack, mean of both sides."),
    Column("geodesic_mean", "mean error", 1, "low", "Geodesic distance to the right point, × 100 / √area."),
    Column(
        "matched", "matched %", 0, about="Points that have a match; one without counts like a random match."
    ),
    Column(
        "oracle_mean",
        "least error",
        1,
        about="Lowest mean error that any map can have: from each right point to the nearest scanned one.",
    ),
    Column("excess_mean", "excess", 1, "low", "Mean error above the least one of the same points."),
    Column(
        "geodesic_best",
        "with alternatives",
        1,
        about="Mean error of the best among the map and the alternatives that its method gave with it.",
    ),
    Column(
        "alternatives", "alternatives", 1, about="Other maps that a method gave with its map, mean number."
    ),
    Column(
        "probability",
        "probability",
        2,
        about="That a map is the right one, or differs from it in a limb, as its method says; mean.",
    ),
    Column("spread", "±", 1, about="Standard deviation of the mean error over seeds."),
    Column("geodesic_median", "median", 1, "low", "Median over points, mean over maps, × 100 / √area."),
    Column(
        "geodesic_symmetric_mean",
        "symmetric error",
        1,
        "low",
        "Mean error to the truth or to its mirror image, whichever is lower for the whole map.",
    ),
    Column("flip_rate", "flips %", 0, "low", "Maps that are nearer to the mirror image than to the truth."),
    Column("gross_rate", "gross %", 0, "low", "Maps with a mean error above 15."),
    Column(
        "right_limb",
        "right limb",
        2,
        "high",
        "Share of limbs of which most points are mapped to the right limb.",
    ),
    Column(
        "mirror_limb",
        "mirror limb",
        2,
        "low",
        "Share of limbs that come in pairs of which most points are mapped to the other limb of the pair.",
    ),
    Column(
        "pck_auc", "PCK AUC", 3, "high", "Area under the share of points matched within a radius of 0 to 25."
    ),
    Column("medial_mean", "medial error", 1, "low", "Distance between medial centres, × 100 / √area."),
    Column(
        "medial_path_mean",
        "medial path",
        1,
        "low",
        "Distance between medial centres along the body, × 100 / √area.",
    ),
    Column(
        "overlap_iou", "overlap IoU", 2, "high", "Confident points against points that have a counterpart."
    ),
    Column(
        "sure_right",
        "sure right",
        3,
        "",
        "Share of points with confidence over 0.9 whose error is under 10.",
    ),
    Column(
        "eq18", "Eq. 18", 4, about="Of the method's operator at this threshold; within one operator only."
    ),
    Column("seconds_match", "time s", 1, about="To match one pair, operators given."),
    Column(NOTE, "not ranked", about="Why a method comes after the others and is never the best."),
)

PARTIAL = (
    *("oracle_mean", "excess_mean", "gross_rate", "right_limb", "mirror_limb", "medial_path_mean"),
    *("sure_right", "geodesic_best", "alternatives", "probability"),
)
"""Columns of the leaderboard that are shown for regimes under which the scans share little surface."""

STABILITY = (
    Column("dataset", "data set"),
    Column("operator", "operator"),
    Column("views", "views"),
    Column("source_threshold", "threshold τ", 2),
    Column("missing", "missing %", 0),
    Column("scans", "scans", 0),
    Column("eq18", "Eq. 18", 4, about="As written, of the kernel times the area of the reference."),
    Column("eq18_trace", "by heat trace", 5, about="Each kernel divided by its heat trace."),
    Column("eq18_relative", "relative", 3, "low", "Relative to the size of the reference's kernel."),
)


def filled_columns(columns: Sequence[Column], table: pd.DataFrame) -> list[Column]:
    """The columns that say something: those with at least one value."""
    return [c for c in columns if c.name in table and table[c.name].notna().any()]


def cell_text(value: object, column: Column) -> str:
    """A cell as people read it: one line, without control characters."""
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return "–"
    return printable(str(value)) if column.digits is None else f"{float(value):.{column.digits}f}"  # type: ignore[arg-type]


def interval_text(low: float, high: float, digits: int = 2) -> str:
    """An interval as people read it; a dash where there is none."""
    return "–" if low != low else f"{low:.{digits}f} to {high:.{digits}f}".replace("-", "−")


def best_cells(table: pd.DataFrame, columns: Sequence[Column], group: Sequence[str]) -> set[tuple[int, str]]:
    """(row, column) of the best values of each group.

    With a column `UNBEATEN`, those that nothing beats beyond noise (`reports.tables.statistics.unbeaten`);
    else the best as shown: ties share, equal values have none. Rows that do not compete, by their columns
    ``beyond`` and `NOTE`, are never the best.
    """
    rivals = table[~table["beyond"]] if "beyond" in table else table
    rivals = rivals[rivals[NOTE].isna()] if NOTE in rivals else rivals
    if UNBEATEN in rivals:
        shown = {column.name for column in columns}
        return {(row, name) for row, names in rivals[UNBEATEN].items() for name in names & shown}
    found = set()
    for _, rows in rivals.groupby(list(group), sort=False, dropna=False):
        for column in columns:
            values = rows[column.name].dropna()
            if column.best and len(values):
                rounded = values.astype(float).round(column.digits or 0)
                limit = rounded.min() if column.best == "low" else rounded.max()
                if rounded.nunique() > 1:
                    found |= {(row, column.name) for row in rounded.index[rounded == limit]}
    return found

"""Tables of a run: the leaderboard, Eq. 18 by threshold; as Markdown, LaTeX, CSV."""

import os
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd

from datasets_gen.records import atomic_path
from reports.method_order import order_methods

GROUP = ["dataset", "regime"]
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
    Column("spread", "±", 1, about="Standard deviation of the mean error over seeds."),
    Column("geodesic_median", "median", 1, "low", "Median over points, mean over maps, × 100 / √area."),
    Column(
        "geodesic_symmetric_mean",
        "up to flip",
        1,
        "low",
        "Mean error to the truth or to its mirror image, whichever is lower for the whole map.",
    ),
    Column("flip_rate", "flips %", 0, "low", "Maps that are nearer to the mirror image than to the truth."),
    Column(
        "pck_auc", "PCK AUC", 3, "high", "Area under the share of points matched within a radius of 0 to 25."
    ),
    Column("medial_mean", "medial error", 1, "low", "Distance between medial centres, × 100 / √area."),
    Column(
        "overlap_iou", "overlap IoU", 2, "high", "Confident points against points that have a counterpart."
    ),
    Column("eq18", "Eq. 18", 4, "low", "Instability of the method's operator at this threshold."),
    Column("seconds_match", "time s", 1, about="To match one pair, operators given."),
)

STABILITY = (
    Column("dataset", "data set"),
    Column("operator", "operator"),
    Column("views", "views"),
    Column("source_threshold", "threshold τ", 2),
    Column("missing", "missing %", 0),
    Column("scans", "scans", 0),
    Column("eq18", "Eq. 18", 4, "low", "As written, of the kernel times the area of the reference."),
    Column("eq18_trace", "by heat trace", 5, "low", "Each kernel divided by its heat trace."),
    Column("eq18_relative", "relative", 3, "low", "Relative to the size of the reference's kernel."),
)


def plain(table: pd.DataFrame) -> pd.DataFrame:
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

    Parameters
    ----------
    table
        Of `plain`.
    beyond
        Methods that do not compete, of `ceilings`; they come last and are never the best.

    Returns
    -------
    DataFrame
        Columns of `LEADERBOARD` and ``beyond``; empty if nothing was matched.
    """
    maps = _numeric(table[table["kind"] == "matching"])
    if maps.empty:
        return pd.DataFrame(columns=[column.name for column in LEADERBOARD])
    maps["missing"] = 50 * (maps["source_missing"] + maps["target_missing"])
    maps["flip_rate"] = 100 * pd.to_numeric(maps["flipped"].astype("object"), errors="coerce")
    maps["eq18"] = _operator_error(maps, _numeric(table[table["kind"] == "stability"]))
    grouped = maps.groupby([*GROUP, "method"], sort=False)
    means = grouped[[c.name for c in LEADERBOARD if c.name in maps and c.digits is not None]].mean()
    means["maps"] = grouped.size()
    by_seed = maps.groupby([*GROUP, "method", "seed"], sort=False)["geodesic_mean"].mean()
    means["spread"] = by_seed.groupby([*GROUP, "method"], sort=False).std()
    result = means.reset_index()
    place = {key: i for i, key in enumerate(dict.fromkeys(zip(maps["dataset"], maps["regime"], strict=True)))}
    rank = [place[key] for key in zip(result["dataset"], result["regime"], strict=True)]
    result = result.assign(_rank=rank, beyond=result["method"].isin(list(beyond)))
    result = result.sort_values(["_rank", "beyond", "geodesic_mean"], kind="stable")
    return result[[*(c.name for c in LEADERBOARD if c.name in result), "beyond"]].reset_index(drop=True)


def stability(table: pd.DataFrame) -> pd.DataFrame:
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
    for name in (measured - {"maps", "missing", "spread", "flip_rate", "scans"}) | {
        "source_missing",
        "target_missing",
    }:
        rows[name] = pd.to_numeric(rows[name], errors="coerce") if name in rows else np.nan
    if "flipped" not in rows:
        rows["flipped"] = None
    return rows


def _operator_error(maps: pd.DataFrame, stable: pd.DataFrame) -> pd.Series:
    """Eq. 18 of each map's operator at its source's threshold and views, mean over poses; nan if unknown."""
    keys = ["dataset", "operator", "source_threshold", "views"]
    mean = stable.groupby(keys)["eq18"].mean() if not stable.empty else pd.Series(dtype=float)
    found = [mean.get(tuple(row), np.nan) for row in maps[keys].itertuples(index=False)]
    return pd.Series(found, index=maps.index, dtype=float)


def used(columns: Sequence[Column], table: pd.DataFrame) -> list[Column]:
    """The columns that say something: those with at least one value."""
    return [c for c in columns if c.name in table and table[c.name].notna().any()]


def text(value: object, column: Column) -> str:
    """A cell as people read it."""
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return "–"
    return str(value) if column.digits is None else f"{float(value):.{column.digits}f}"  # type: ignore[arg-type]


def best_cells(table: pd.DataFrame, columns: Sequence[Column], group: Sequence[str]) -> set[tuple[int, str]]:
    """(row, column) of the best values of each group; ties as shown share, equal values have none."""
    found = set()
    rivals = table[~table["beyond"]] if "beyond" in table else table
    for _, rows in rivals.groupby(list(group), sort=False, dropna=False):
        for column in columns:
            values = rows[column.name].dropna()
            if column.best and len(values):
                shown = values.astype(float).round(column.digits or 0)
                limit = shown.min() if column.best == "low" else shown.max()
                if shown.nunique() > 1:
                    found |= {(row, column.name) for row in shown.index[shown == limit]}
    return found


def to_markdown(table: pd.DataFrame, columns: Sequence[Column], group: Sequence[str]) -> str:
    """A Markdown table, the best of each group in bold."""
    head = [column.title for column in columns]
    rule = ["---" if column.digits is None else "---:" for column in columns]
    body = _cells(table, columns, group, lambda cell: f"**{cell}**", lambda cell: cell.replace("|", "\\|"))
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, rule, *body]) + "\n"


def to_latex(table: pd.DataFrame, columns: Sequence[Column], group: Sequence[str]) -> str:
    """A LaTeX table (package booktabs), the best of each group in bold, a rule between groups."""
    align = "".join("l" if column.digits is None else "r" for column in columns)
    head = " & ".join(_tex(column.title) for column in columns) + r" \\"
    body = _cells(table, columns, group, lambda cell: rf"\textbf{{{cell}}}", _tex)
    lines = []
    keys = list(table[list(group)].itertuples(index=False, name=None))
    for i, row in enumerate(body):
        if i and keys[i] != keys[i - 1]:
            lines.append(r"\midrule")
        lines.append(" & ".join(row) + r" \\")
    parts = [
        rf"\begin{{tabular}}{{{align}}}",
        r"\toprule",
        head,
        r"\midrule",
        *lines,
        r"\bottomrule",
        r"\end{tabular}",
    ]
    return "\n".join(parts) + "\n"


def _cells(
    table: pd.DataFrame,
    columns: Sequence[Column],
    group: Sequence[str],
    bold: Callable[[str], str],
    escape: Callable[[str], str],
) -> list[list[str]]:
    best = best_cells(table, columns, group)
    rows = []
    for i, row in table.iterrows():
        cells = {c.name: escape(text(row[c.name], c)) for c in columns}
        rows.append([bold(cells[c.name]) if (i, c.name) in best else cells[c.name] for c in columns])
    return rows


_TEX = {"\\": r"\textbackslash{}", "τ": r"$\tau$", "±": r"$\pm$", "–": "--"}
_TEX |= {c: "\\" + c for c in "&%$#_{}"} | {"~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}


def _tex(value: str) -> str:
    return "".join(_TEX.get(character, character) for character in value)


def write(
    table: pd.DataFrame,
    columns: Sequence[Column],
    group: Sequence[str],
    folder: str | os.PathLike[str],
    name: str,
) -> dict[str, Path]:
    """Write ``name.md``, ``name.tex`` and ``name.csv``; return the paths by suffix."""
    shown = used(columns, table)
    plain = table[[column.name for column in shown]].to_csv(index=False)
    contents = {
        "md": to_markdown(table, shown, group),
        "tex": to_latex(table, shown, group),
        "csv": plain,
    }
    paths = {}
    for suffix, content in contents.items():
        paths[suffix] = Path(folder) / f"{name}.{suffix}"
        with atomic_path(paths[suffix]) as temporary:
            temporary.write_text(content, encoding="utf-8")
    return paths

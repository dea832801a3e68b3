"""From tables and pictures to the HTML page."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import pandas as pd

from reports.figures.style import method_colors
from reports.method_order import order_methods
from reports.tables.columns import (
    GROUP,
    LEADERBOARD,
    NOTE,
    PARTIAL,
    STABILITY,
    STABILITY_GROUP,
    Column,
    best_cells,
    cell_text,
    filled_columns,
)
from reports.tables.completeness import unranked
from reports.viewer.view_page import REGL, resource

if TYPE_CHECKING:
    from reports.page.pictures import PagePicture

SECTIONS = ("missing", "pck", "stability", "pairs", "scans")
"""Where pictures may be on the page."""

BOARD = tuple(column for column in LEADERBOARD if column.name not in ("maps", "missing"))
"""Columns of the leaderboard on the page, where every regime has a head of its own."""


EXPLAINED = ("matched", NOTE, "overlap_iou", "spread", "missing", *PARTIAL)
"""Columns that the page explains by what the tables say of them."""


@dataclass
class PageData:
    """Everything that the page shows.

    Attributes
    ----------
    info, settings : Mapping
        Of the store: what made the results; the experiment.
    table, leaderboard, stability, failures : DataFrame
    pictures : dict of lists
        By section.
    pairs_left_out : int
        Pairs of scans that were not drawn.
    aside : set of str
        Names of the pictures of pairs whose views are in files of their own.
    """

    info: Mapping[str, Any]
    settings: Mapping[str, Any]
    table: pd.DataFrame
    leaderboard: pd.DataFrame
    stability: pd.DataFrame
    failures: pd.DataFrame
    pictures: "dict[str, list[PagePicture]]" = field(default_factory=dict)
    pairs_left_out: int = 0
    aside: set[str] = field(default_factory=set)


@dataclass(frozen=True)
class TableCell:
    """A cell: its text, whether it is a number and the best of its group, and a bar in [0, 1] or None."""

    text: str
    number: bool = False
    best: bool = False
    bar: float | None = None


@dataclass(frozen=True)
class TableBlock:
    """Rows of a table under one head, such as a regime, and what holds for all of them."""

    head: str
    about: str
    rows: list[list[TableCell]]


def render_page(data: PageData) -> str:
    """The page as HTML: styles inside, figures beside it under ``figures/``."""
    import jinja2

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    environment.filters["file"] = lambda picture: f"figures/{picture.name}"
    board = data.leaderboard
    beyond = set(board.loc[board["beyond"], "method"]) if len(board) else set()
    template = environment.from_string(_resource("report.html.j2"))
    return template.render(
        style=_resource("report.css"),
        script=_resource("report.js"),
        regl=resource(REGL),
        viewer=resource("viewer.js"),
        viewer_style=resource("viewer.css"),
        aside=data.aside,
        title=data.settings.get("name", "results"),
        description=data.settings.get("description", ""),
        facts=list(facts(data)),
        sentence=headline(data.table, beyond),
        overall=overall(data.table, beyond),
        colors=method_colors(data.leaderboard["method"]) if len(data.leaderboard) else {},
        board=blocks(data.leaderboard, BOARD, GROUP, "geodesic_mean", "regime"),
        board_columns=filled_columns(BOARD, data.leaderboard)[len(GROUP) :],
        explained=EXPLAINED,
        stable=blocks(data.stability, STABILITY, STABILITY_GROUP, "eq18_relative", ""),
        stable_columns=filled_columns(STABILITY, data.stability)[1:] if len(data.stability) else [],
        pictures={name: data.pictures.get(name, []) for name in SECTIONS},
        groups=list(dict.fromkeys(p.group for p in data.pictures.get("pairs", []))),
        left_out=data.pairs_left_out,
        failures=data.failures.to_dict("records"),
        run=list(flat(data.info)),
        experiment=_toml_like(data.settings),
    )


def overall(table: pd.DataFrame, beyond: Collection[str] = ()) -> list[dict[str, Any]]:
    """Means of each method over all maps, the lowest error first.

    Those with incomplete maps come after the others, those beyond competition last.
    """
    maps = table[table["kind"] == "matching"]
    rows, notes = [], unranked(maps)
    for method in order_methods(maps["method"]):
        part = maps[maps["method"] == method]
        flips = part["flipped"].astype(float)
        rows.append(
            {
                "method": method,
                "mean": float(part["geodesic_mean"].mean()),
                "median": float(part["geodesic_median"].mean()),
                "auc": float(part["pck_auc"].mean()),
                "flips": None if flips.isna().all() else 100 * float(flips.mean()),
                "maps": len(part),
                "matched": 100 * float(part["matched"].mean()) if "matched" in part else float("nan"),
                "beyond": method in beyond,
                "note": notes.get(method, ""),
            }
        )
    return sorted(rows, key=lambda row: (row["beyond"], row["note"] != "", row["mean"]))


def _unranked(table: pd.DataFrame) -> dict[str, str]:
    return unranked(table[table["kind"] == "matching"])


def headline(table: pd.DataFrame, beyond: Collection[str] = ()) -> str:
    """The main result in one sentence; empty if fewer than two methods compete with complete maps."""
    table = table[~table["method"].isin([*beyond, *_unranked(table)])]
    ranking = overall(table)
    if len(ranking) < 2:
        return ""
    first, second = ranking[0], ranking[1]
    groups = table[table["kind"] == "matching"].groupby([*GROUP, "method"])["geodesic_mean"].mean()
    winners = groups.groupby(GROUP).idxmin().map(lambda key: key[-1])
    won, won_second = (int((winners == row["method"]).sum()) for row in (first, second))
    means = [f"{row['mean']:.1f}" for row in (first, second)]
    if means[0] == means[1]:
        return (
            f"Over all maps, {first['method']} and {second['method']} have the same mean geodesic error, "
            f"{means[0]} (× 100 / √area); of {len(winners)} groups of data set and regime, the first is the "
            f"best in {won} and the second in {won_second}."
        )
    return (
        f"Over all maps, {first['method']} has the lowest mean geodesic error, {means[0]} "
        f"(× 100 / √area), ahead of {second['method']} with {means[1]}; it is the best in "
        f"{won} of {len(winners)} groups of data set and regime."
    )


def facts(data: PageData) -> Iterator[tuple[str, str]]:
    """A few numbers for the head of the page."""
    table = data.table
    maps = table[table["kind"] == "matching"]
    yield "data sets", str(table["dataset"].nunique())
    yield "scans", str(pd.concat([table["source_scan"], table["target_scan"]]).nunique())
    if len(maps):
        yield "methods", str(maps["method"].nunique())
        yield "maps", str(len(maps))
    points = sorted(table["n_points"].dropna().astype(int).unique())
    if points:
        yield "points per scan", f"{points[0]:,}" if len(points) == 1 else f"{points[0]:,} to {points[-1]:,}"
    seeds = table["seed"].nunique()
    yield "seed" if seeds == 1 else "seeds", str(seeds)
    if data.info.get("wall_seconds"):
        yield "last run", _duration(float(data.info["wall_seconds"]))
    if len(data.failures):
        yield "failures", str(len(data.failures))


def blocks(
    table: pd.DataFrame, columns: Sequence[Column], group: Sequence[str], bar: str, second: str
) -> dict[str, list[TableBlock]]:
    """Rows by data set, then by the column `second` if given; the head columns are left out of the rows."""
    if table.empty:
        return {}
    shown = filled_columns(columns, table)
    best = best_cells(table, shown, group)
    longest = table.groupby("dataset")[bar].max() if bar in table else {}
    found: dict[str, list[TableBlock]] = {}
    keys = ["dataset", second] if second else ["dataset"]
    for key, rows in table.groupby(keys, sort=False, dropna=False):
        cells = [
            [
                TableCell(
                    cell_text(row[c.name], c),
                    c.digits is not None,
                    (i, c.name) in best,
                    _share(row[c.name], longest[row["dataset"]]) if c.name == bar else None,
                )
                for c in shown
                if c.name not in keys
            ]
            for i, row in rows.iterrows()
        ]
        head, about = (str(key[1]), _common(rows)) if second else ("", "")
        found.setdefault(str(key[0]), []).append(TableBlock(head, about, cells))
    return found


def _common(rows: pd.DataFrame) -> str:
    """Number of maps and missing surface, which the methods of a regime share."""
    maps = sorted(rows["maps"].astype(int).unique())
    count = f"{maps[0]}" if len(maps) == 1 else f"{maps[0]} to {maps[-1]}"
    noun = "map" if count == "1" else "maps"
    return f"{count} {noun} per method, {rows['missing'].mean():.0f} % of the surface missing"


def flat(info: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, str]]:
    """Nested facts as lines of name and value, without what only the program reads."""
    for name, value in info.items():
        label = f"{before}{name}".replace("_", " ")
        if name in ("format", "rows_digest", "datasets", "files"):
            continue
        if isinstance(value, Mapping):
            yield from flat(value, f"{before}{name}: ")
        elif isinstance(value, list):
            yield label, ", ".join(map(str, value))
        else:
            yield label, f"{value:.1f}" if isinstance(value, float) else str(value)


def _toml_like(settings: Mapping[str, Any]) -> str:
    from evaluation.experiment.toml_tables import to_toml

    return to_toml(settings)


def _share(value: Any, longest: Any) -> float:
    return float(value / longest) if longest and value == value else 0.0


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.1f} min"


def _resource(name: str) -> str:
    return files("reports.page").joinpath(name).read_text(encoding="utf-8")

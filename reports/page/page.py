"""From tables and pictures to the HTML page."""

import re
from base64 import b64encode
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import pandas as pd

from evaluation.results.origin import Origin
from reports.figures.style import method_colors
from reports.page.headline import headline, overall
from reports.page.page_rows import pair_key
from reports.tables.columns import (
    GROUP,
    LEADERBOARD,
    STABILITY,
    STABILITY_GROUP,
    Column,
    best_cells,
    cell_text,
    filled_columns,
)
from reports.tables.leaderboard import RATES
from reports.viewer.view_page import REGL, resource

if TYPE_CHECKING:
    from reports.page.pictures import PagePicture
    from reports.page.scan_choice import ScanChoice

SCRIPTS = ("page_tools.js", "report.js", "board.js", "charts.js", "all_maps.js")
"""In the order in which they build on each other."""
OWN_TERMS = ("geodesic_mean", "flip_rate", "medial_mean", "eq18")
"""Columns that the page explains in words of its own."""
BIBTEX = """@misc{{medialbench,
  author = {{{{The medialbench authors}}}},
  year = {{2026}},
  title = {{medialbench: how well incomplete scans of deforming shapes can be matched}},
  note = {{{note}}}
}}
@article{{berger2012nonrigid,
  author = {{Berger, Matthew and Silva, Claudio T.}},
  title = {{Nonrigid Matching of Undersampled Shapes via Medial Diffusion}},
  journal = {{Computer Graphics Forum}},
  volume = {{31}},
  number = {{5}},
  year = {{2012}}
}}"""

SECTIONS = ("missing", "pck", "stability", "pairs", "scans")
"""Where pictures may be on the page."""

BOARD = tuple(column for column in LEADERBOARD if column.name not in ("maps", "missing"))
"""Columns of the leaderboard on the page, where every regime has a head of its own."""


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
    scans : list of ScanChoice
    rows : str
        What the scripts read, of `reports.page.page_rows.page_json`; empty without maps.
    aside : set of str
        Names of the pictures of pairs, and of the scans, whose views are in files of their own.
    """

    info: Mapping[str, Any]
    settings: Mapping[str, Any]
    table: pd.DataFrame
    leaderboard: pd.DataFrame
    stability: pd.DataFrame
    failures: pd.DataFrame
    pictures: "dict[str, list[PagePicture]]" = field(default_factory=dict)
    pairs_left_out: int = 0
    scans: "list[ScanChoice]" = field(default_factory=list)
    rows: str = ""
    aside: set[str] = field(default_factory=set)

    def drawn(self) -> dict[str, str]:
        """Name of the picture of each drawn pair of scans, by `reports.page.page_rows.pair_key`."""
        return {picture.pair: picture.name for picture in self.pictures.get("pairs", [])}


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
    board, experiment = data.leaderboard, _toml_like(data.settings)
    name = re.sub(r"[^\w.-]+", "-", str(data.settings.get("name", "experiment"))).strip("-.") or "experiment"
    beyond = set(board.loc[board["beyond"], "method"]) if len(board) else set()
    template = environment.from_string(_resource("report.html.j2"))
    return template.render(
        style=_resource("report.css"),
        scripts=[_resource(name) for name in SCRIPTS],
        rows=data.rows,
        scans=data.scans,
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
        terms=terms(data),
        examples=examples(data, beyond),
        stable=blocks(data.stability, STABILITY, STABILITY_GROUP, "eq18_relative", ""),
        stable_columns=filled_columns(STABILITY, data.stability)[1:] if len(data.stability) else [],
        pictures={name: data.pictures.get(name, []) for name in SECTIONS},
        groups=list(dict.fromkeys(p.group for p in data.pictures.get("pairs", []))),
        left_out=data.pairs_left_out,
        failures=data.failures.to_dict("records"),
        run=list(flat(data.info)),
        experiment=experiment,
        toml_data=b64encode(experiment.encode()).decode(),
        toml_name=f"{name}.toml",
        title_name=name,
        bibtex=BIBTEX.format(note=_tex(Origin.of_run(data.info).line)),
    )


@dataclass(frozen=True)
class ExampleMap:
    """A map that the head of the page shows: the picture of its pair, and what it is."""

    name: str
    words: str


def examples(data: PageData, beyond: Collection[str] = ()) -> list[ExampleMap]:
    """The best and the worst map of the first method, among the pairs that were drawn."""
    drawn = {picture.pair: picture for picture in data.pictures.get("pairs", [])}
    ranking = [row for row in overall(data.table, beyond) if not row["beyond"] and not row["note"]]
    if len(drawn) < 2 or not ranking:
        return []
    method = ranking[0]["method"]
    maps = data.table[(data.table["kind"] == "matching") & (data.table["method"] == method)]
    maps = maps.assign(pair=maps.apply(pair_key, axis=1)).dropna(subset=["geodesic_mean"])
    maps = maps[maps["pair"].isin(list(drawn))]
    if len(maps) < 2:
        return []
    maps = maps.sort_values("geodesic_mean", kind="stable")
    return [
        ExampleMap(
            drawn[row["pair"]].name,
            f"{word} of the drawn maps of {method}: {drawn[row['pair']].title}, {row['regime']}, "
            f"mean error {row['geodesic_mean']:.1f}",
        )
        for word, row in (("best", maps.iloc[0]), ("worst", maps.iloc[-1]))
    ]


def terms(data: PageData) -> list[Column]:
    """Columns of the tables that the glossary explains by what these say of them, each once."""
    names = {*data.table.columns, *data.leaderboard.columns}  # any measure can be chosen in the leaderboard
    shown = [c for c in LEADERBOARD if RATES.get(c.name, c.name) in names] if len(data.leaderboard) else []
    shown += filled_columns(STABILITY, data.stability)
    return list({c.name: c for c in shown if c.about and c.name not in OWN_TERMS}.values())


def facts(data: PageData) -> Iterator[tuple[str, str]]:
    """A few numbers for the head of the page."""
    table = data.table
    maps = table[table["kind"] == "matching"]
    yield _fact(table["dataset"].nunique(), "data set")
    yield _fact(pd.concat([table["source_scan"], table["target_scan"]]).nunique(), "scan")
    if len(maps):
        yield _fact(maps["method"].nunique(), "method")
        yield _fact(len(maps), "map")
    points = sorted(table["n_points"].dropna().astype(int).unique())
    if points:
        yield "points per scan", f"{points[0]:,}" if len(points) == 1 else f"{points[0]:,} to {points[-1]:,}"
    yield _fact(table["seed"].nunique(), "seed")
    if data.info.get("wall_seconds"):
        yield "last run", _duration(float(data.info["wall_seconds"]))
    if len(data.failures):
        yield _fact(len(data.failures), "failure")


def _fact(count: int, noun: str) -> tuple[str, str]:
    return noun if count == 1 else f"{noun}s", f"{count:,}"


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
    from evaluation.experiment.experiment import portable
    from evaluation.experiment.toml_tables import to_toml

    return to_toml(portable(settings))


def _tex(text: str) -> str:
    """Text for a BibTeX field, without what would end or change it."""
    return re.sub(r"[^\w .,:;()+-]", " ", text)


def _share(value: Any, longest: Any) -> float:
    return float(value / longest) if longest and value == value else 0.0


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.1f} min"


def _resource(name: str) -> str:
    return files("reports.page").joinpath(name).read_text(encoding="utf-8")

"""The report: every figure and table of a results folder, and one page that shows them."""

import json
import os
import re
from collections.abc import Callable
from pathlib import Path

from datasets_gen.records import atomic_path
from evaluation.results.origin import Origin, write_csv
from evaluation.results.store import ResultsStore
from reports.page.freshness import PAIRS, note_made
from reports.page.page import PageData, render_page
from reports.page.page_rows import page_json
from reports.page.pictures import (
    Drawing,
    PagePicture,
    drawn,
    figure_jobs,
    pair_groups,
    scan_views,
)
from reports.page.scan_choice import ScanChoice, scan_choices
from reports.tables.columns import GROUP, LEADERBOARD, STABILITY, STABILITY_GROUP
from reports.tables.formats import write_table
from reports.tables.leaderboard import ceilings, leaderboard, stability_table, with_numpy_types

EMBEDDED = 4_000_000
"""Bytes of views that are part of the page; what comes after lies beside it."""

Progress = Callable[[str, int, int], None]


def build(
    results_folder: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    *,
    pairs: int | None = PAIRS,
    jobs: int = 1,
    progress: Progress | None = None,
) -> Path:
    """Write tables (md, tex, csv), figures (pdf, png) and ``index.html`` of a run.

    Parameters
    ----------
    results_folder
        Made by `evaluation.run`.
    out
        Folder of the report, by default ``report`` in the results folder; files there are replaced.
    pairs
        Largest number of pairs of scans to draw, spread evenly over data sets and regimes; None for all.
    jobs
        Processes that draw. With more than one, a script that calls this needs the usual
        ``if __name__ == "__main__":``, as they are started afresh.
    progress
        Called after each figure: what it shows, the number of finished figures and of all.

    Returns
    -------
    Path
        Of ``index.html``. It refers to files beside it only and needs no network. The views of pairs beyond
        `EMBEDDED` bytes are files beside it, too, which a browser reads when they are asked for.

    Raises
    ------
    InputError
        If the folder holds no results, or `out` cannot be written.
    """
    store = ResultsStore(results_folder)
    table = with_numpy_types(store.table())
    folder = Path(out) if out is not None else Path(results_folder) / "report"
    data = PageData(
        info=store.run_info(),
        settings=store.settings,
        table=table,
        leaderboard=leaderboard(table, ceilings(store.settings)),
        stability=stability_table(table),
        failures=store.failures(),
    )
    _write_tables(data, folder / "tables")
    figures = folder / "figures"
    todo = figure_jobs(store, table, figures, pairs)
    for done, (job, picture) in enumerate(drawn(todo, Drawing(store.folder, figures, pairs), jobs)):
        data.pictures.setdefault(job.section, []).append(picture)
        if progress:
            progress(job.label, done + 1, len(todo))
    shown = len(data.pictures.get("pairs", []))
    if len(data.leaderboard) or len(data.stability):
        data.rows = page_json(store, table, ceilings(store.settings), data.drawn())
    data.scans = list(scan_choices(store, scan_views(table)))
    data.pairs_left_out = len(pair_groups(table[table["kind"] == "matching"])) - shown
    _write_views(data, folder / "views")
    _remove_stale(folder, {*(p.name for p in data.pictures.get("pairs", [])), *(s.name for s in data.scans)})
    index = folder / "index.html"
    with atomic_path(index) as temporary:
        temporary.write_text(render_page(data), encoding="utf-8")
    note_made(store, folder, pairs)
    return index


def _remove_stale(folder: Path, made: set[str]) -> None:
    """Remove pictures and views of pairs and scans that an earlier report had and this one lacks."""
    for file in [*folder.glob("figures/pair-*"), *folder.glob("views/*.js")]:
        if file.stem not in made and re.fullmatch(r"(pair|scan)-\d+", file.stem):
            file.unlink()


def _write_views(data: PageData, folder: Path) -> None:
    """Views that would make the page heavy go into files, which set what the page asks for."""
    size = 0
    shown: list[PagePicture | ScanChoice] = [*data.pictures.get("pairs", []), *data.scans]
    for picture in shown:
        size += len(picture.view)
        if picture.view and size > EMBEDDED:
            data.aside.add(picture.name)
            with atomic_path(folder / f"{picture.name}.js") as temporary:
                text = f"window.medialScenes[{json.dumps(picture.name)}] = {json.dumps(picture.view)};\n"
                temporary.write_text(text, encoding="utf-8")


def _write_tables(data: PageData, folder: Path) -> None:
    origin = Origin.of_run(data.info)
    for name, table, columns, group in (
        ("correspondence", data.leaderboard, LEADERBOARD, GROUP),
        ("stability", data.stability, STABILITY, STABILITY_GROUP),
    ):
        if not table.empty:
            write_table(table, columns, group, folder, name, origin)
    write_csv(data.table, folder / "scores.csv", origin)

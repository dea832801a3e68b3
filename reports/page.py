"""The report: every figure and table of a results folder, and one page that shows them."""

import os
from collections.abc import Callable
from pathlib import Path

from datasets_gen.records import atomic_path
from evaluation.store import ResultsStore
from reports import tables
from reports.html.render import PageData, render_page
from reports.sections import Picture, jobs, pair_groups

PAIRS = 24
"""Pairs drawn by default; a sweep may have thousands."""

Progress = Callable[[str, int, int], None]


def build(
    results_folder: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    *,
    pairs: int | None = PAIRS,
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
    progress
        Called with what comes next, the number of finished figures and of all figures.

    Returns
    -------
    Path
        Of ``index.html``. It refers to files beside it only and needs no network.

    Raises
    ------
    InputError
        If the folder holds no results, or `out` cannot be written.
    """
    store = ResultsStore(results_folder)
    table = tables.plain(store.table())
    folder = Path(out) if out is not None else Path(results_folder) / "report"
    data = PageData(
        info=store.run_info(),
        settings=store.settings,
        table=table,
        leaderboard=tables.leaderboard(table),
        stability=tables.stability(table),
        failures=store.failures(),
    )
    _write_tables(data, folder / "tables")
    todo = jobs(store, table, folder / "figures", pairs)
    for done, job in enumerate(todo):
        if progress:
            progress(job.label, done, len(todo))
        data.pictures.setdefault(job.section, []).append(job.draw())
    drawn = len(data.pictures.get("pairs", []))
    data.pairs_left_out = len(pair_groups(table[table["kind"] == "matching"])) - drawn
    index = folder / "index.html"
    with atomic_path(index) as temporary:
        temporary.write_text(render_page(data), encoding="utf-8")
    if progress:
        progress("done", len(todo), len(todo))
    return index


def _write_tables(data: PageData, folder: Path) -> None:
    for name, table, columns, group in (
        ("correspondence", data.leaderboard, tables.LEADERBOARD, tables.GROUP),
        ("stability", data.stability, tables.STABILITY, tables.STABILITY_GROUP),
    ):
        if not table.empty:
            tables.write(table, columns, group, folder, name)
    with atomic_path(folder / "scores.csv") as temporary:
        data.table.to_csv(temporary, index=False)


__all__ = ["PAIRS", "Picture", "build"]

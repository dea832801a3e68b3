"""Tables for the terminal, as lines with rich's markup."""

from collections.abc import Iterator, Mapping, Sequence

import pandas as pd
from rich.cells import cell_len
from rich.markup import escape

from evaluation.results.outcome import printable
from reports.tables.columns import (
    GROUP,
    LEADERBOARD,
    NOTE,
    Column,
    best_cells,
    cell_text,
    filled_columns,
    interval_text,
)
from reports.tables.statistics import FEWEST

NARROW = ("method", "missing", "geodesic_mean", "matched", "geodesic_median", "flip_rate", "pck_auc", "eq18")
"""Columns that fit a terminal of 80 characters."""

WIDE = (*NARROW, "maps", "spread", "geodesic_symmetric_mean", "medial_mean", "seconds_match")
"""Columns from `ROOM` characters on."""

PARTIAL_NARROW, PARTIAL_WIDE = (
    ("excess_mean", "right_limb"),
    ("oracle_mean", "excess_mean", "right_limb", "gross_rate"),
)
"""Further columns where the scans of a regime share little surface; those of `MAKE_WAY` then make way."""

MAKE_WAY = ("eq18", "geodesic_symmetric_mean", "maps")
MAKE_WAY_NARROW = (*MAKE_WAY, "geodesic_median")

ROOM = 120
MARK = "†"
"""Behind the names of methods that are not ranked."""

TESTS = (
    Column("first", "lower error"),
    Column("second", "than"),
    Column("difference", "mean difference", 2),
    Column("interval", "95 % interval"),
    Column("pairs", "pose pairs", 0),
    Column("wins", "better on", 0),
    Column("ties", "tied on", 0),
    Column("p", "p (Wilcoxon, Holm)", 4),
)


def leaderboard_lines(board: pd.DataFrame, width: int) -> Iterator[str]:
    """The leaderboard under a head per data set and regime, the best values of each in bold.

    Methods that are not ranked have a mark, which is explained below.

    Parameters
    ----------
    board
        Of `reports.tables.leaderboard.leaderboard`.
    width
        Characters per line.
    """
    columns = _fitting(filled_columns(LEADERBOARD, board), width)
    heads = [f"{row['dataset']}, {row['regime']}" for _, row in board.iterrows()]
    notes = board[NOTE] if NOTE in board else pd.Series(None, board.index, dtype=object)
    marked = [f"{name} {MARK}" if note else name for name, note in zip(board["method"], notes, strict=True)]
    yield from _lines(board.assign(method=marked), columns, heads, best_cells(board, columns, GROUP))
    yield f"[dim]errors × 100 / √area of the rest pose; bold: not beaten beyond noise, {FEWEST}+ pairs[/]"
    for head, name, note in zip(heads, board["method"], notes, strict=True):
        if note:
            yield f"[dim]{MARK} not ranked: {escape(printable(f'{head}, {name}: {note}'))}[/]"


def _fitting(filled: Sequence[Column], width: int) -> list[Column]:
    """The columns of a leaderboard that fit the terminal."""
    wide = width >= ROOM
    names: tuple[str, ...] = WIDE if wide else NARROW
    further = PARTIAL_WIDE if wide else PARTIAL_NARROW
    if any(column.name in further for column in filled):
        names = (*(name for name in names if name not in (MAKE_WAY if wide else MAKE_WAY_NARROW)), *further)
    if any(column.name == NOTE for column in filled):  # marks need room
        names = tuple(name for name in names if name != "eq18")
    return [column for column in filled if column.name in names]


def tests_lines(tests: pd.DataFrame, measure: str, left_out: Mapping[str, str]) -> Iterator[str]:
    """Paired comparisons of methods, of `reports.tables.statistics.paired_tests`; and who was left out."""
    interval = [interval_text(low, high) for low, high in zip(tests["low"], tests["high"], strict=True)]
    yield from _lines(tests.assign(interval=interval), TESTS, None, set())
    yield f"[dim]{measure}, on the maps that both methods have; a pair of poses is one piece of evidence[/]"
    for method, why in left_out.items():
        yield f"[dim]not compared: {escape(printable(f'{method}: {why}'))}[/]"


def _lines(
    table: pd.DataFrame, columns: Sequence[Column], heads: list[str] | None, best: set[tuple[int, str]]
) -> Iterator[str]:
    """Heads in two lines, then rows; a line of its own wherever the head of a group changes."""
    titles = [_split(column.title) for column in columns]
    cells = [[cell_text(row[c.name], c) for c in columns] for _, row in table.iterrows()]
    widths = [
        max(cell_len(word) for word in (*title, *(row[i] for row in cells))) for i, title in enumerate(titles)
    ]
    for level in (0, 1):
        yield "[bold]" + _join([title[level] for title in titles], columns, widths) + "[/]"
    yield "[dim]" + "─" * (sum(widths) + 2 * (len(widths) - 1)) + "[/]"
    before = None
    for i, row in enumerate(cells):
        if heads is not None and heads[i] != before:
            yield f"[cyan]{escape(printable(heads[i]))}[/]"
            before = heads[i]
        marks = [(table.index[i], column.name) in best for column in columns]
        yield _join(row, columns, widths, marks)


def _split(title: str) -> tuple[str, str]:
    """A head in two lines, the lower one first filled."""
    first, _, last = title.rpartition(" ")
    return first, last


def _join(
    cells: Sequence[str], columns: Sequence[Column], widths: Sequence[int], bold: Sequence[bool] | None = None
) -> str:
    parts = []
    for i, (cell, column, width) in enumerate(zip(cells, columns, widths, strict=True)):
        room = " " * (width - cell_len(cell))
        text = f"[bold]{escape(cell)}[/]" if bold and bold[i] else escape(cell + " ")[:-1]  # no tag follows
        parts.append(text + room if column.digits is None else room + text)
    return "  ".join(parts)

"""Tables for the terminal, as lines with rich's markup."""

from collections.abc import Iterator, Sequence

import pandas as pd

from reports.tables.columns import GROUP, LEADERBOARD, Column, best_cells, cell_text, filled_columns

NARROW = ("method", "missing", "geodesic_mean", "geodesic_median", "flip_rate", "pck_auc", "eq18")
"""Columns that fit a terminal of 80 characters."""

WIDE = (*NARROW, "maps", "spread", "geodesic_symmetric_mean", "medial_mean", "seconds_match")
"""Columns from `ROOM` characters on."""

PARTIAL_NARROW, PARTIAL_WIDE = (
    ("excess_mean", "right_limb"),
    ("oracle_mean", "excess_mean", "right_limb", "gross_rate"),
)
"""Further columns where the scans of a regime share little surface; those of `MAKE_WAY` then make way."""

MAKE_WAY = ("eq18", "geodesic_symmetric_mean")

ROOM = 120

TESTS = (
    Column("first", "lower error"),
    Column("second", "than"),
    Column("pairs", "pairs", 0),
    Column("difference", "median difference", 2),
    Column("wins", "better on %", 0),
    Column("p", "p (Wilcoxon, Holm)", 4),
)


def leaderboard_lines(board: pd.DataFrame, width: int) -> Iterator[str]:
    """The leaderboard under a head per data set and regime, the best values of each in bold.

    Parameters
    ----------
    board
        Of `reports.tables.leaderboard.leaderboard`.
    width
        Characters per line.
    """
    columns = _fitting(filled_columns(LEADERBOARD, board), width)
    heads = [f"{row['dataset']}, {row['regime']}" for _, row in board.iterrows()]
    yield from _lines(board, columns, heads, best_cells(board, columns, GROUP))
    yield "[dim]errors × 100 / √area of the rest pose; bold: the best of a group[/]"


def _fitting(filled: Sequence[Column], width: int) -> list[Column]:
    """The columns of a leaderboard that fit the terminal."""
    names, further = (WIDE, PARTIAL_WIDE) if width >= ROOM else (NARROW, PARTIAL_NARROW)
    if any(column.name in further for column in filled):
        names = (*(name for name in names if name not in MAKE_WAY), *further)
    return [column for column in filled if column.name in names]


def tests_lines(tests: pd.DataFrame, measure: str) -> Iterator[str]:
    """Paired comparisons of methods, of `reports.tables.statistics.paired_tests`."""
    yield from _lines(tests.assign(wins=100 * tests["wins"]), TESTS, None, set())
    yield f"[dim]{measure}, on the pairs of scans that both methods matched; seeds averaged[/]"


def _lines(
    table: pd.DataFrame, columns: Sequence[Column], heads: list[str] | None, best: set[tuple[int, str]]
) -> Iterator[str]:
    """Heads in two lines, then rows; a line of its own wherever the head of a group changes."""
    titles = [_split(column.title) for column in columns]
    cells = [[cell_text(row[c.name], c) for c in columns] for _, row in table.iterrows()]
    widths = [
        max(len(word) for word in (*title, *(row[i] for row in cells))) for i, title in enumerate(titles)
    ]
    for level in (0, 1):
        yield "[bold]" + _join([title[level] for title in titles], columns, widths) + "[/]"
    yield "[dim]" + "─" * (sum(widths) + 2 * (len(widths) - 1)) + "[/]"
    before = None
    for i, row in enumerate(cells):
        if heads is not None and heads[i] != before:
            yield f"[cyan]{heads[i]}[/]"
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
        padded = cell.ljust(width) if column.digits is None else cell.rjust(width)
        parts.append(padded.replace(cell, f"[bold]{cell}[/]") if bold and bold[i] and cell else padded)
    return "  ".join(parts)

"""Tables for the terminal."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import pandas as pd

from reports.tables import GROUP, LEADERBOARD, Column, best_cells, text, used

if TYPE_CHECKING:
    from rich.table import Table

SHORT = (
    "method",
    "maps",
    "missing",
    "geodesic_mean",
    "spread",
    "geodesic_median",
    "geodesic_symmetric_mean",
    "flip_rate",
    "pck_auc",
    "eq18",
    "seconds_match",
)


def leaderboard_table(board: pd.DataFrame) -> "Table":
    """The leaderboard, a section per data set and regime, the best values in bold."""
    columns = [c for c in used(LEADERBOARD, board) if c.name in SHORT]
    first = Column("place", "data set, regime")
    caption = "errors × 100 / √area of the rest pose; the best of each group is bold"
    best = best_cells(board, columns, GROUP)
    table = _empty([first, *columns], caption)
    before = None
    for i, row in board.iterrows():
        place = f"{row['dataset']}, {row['regime']}"
        if before not in (None, place):
            table.add_section()
        cells = [text(row[c.name], c) for c in columns]
        marked = [
            f"[bold]{cell}[/]" if (i, c.name) in best else cell
            for c, cell in zip(columns, cells, strict=True)
        ]
        table.add_row(place if place != before else "", *marked)
        before = place
    return table


def tests_table(tests: pd.DataFrame, measure: str) -> "Table":
    """Paired comparisons of methods."""
    columns = [
        Column("first", "lower error"),
        Column("second", "than"),
        Column("pairs", "pairs", 0),
        Column("difference", "median difference", 2),
        Column("wins", "better on %", 0),
        Column("p", "p (Wilcoxon, Holm)", 4),
    ]
    table = _empty(columns, f"of {measure}, on the pairs of scans that both methods matched; seeds averaged")
    for _, row in tests.assign(wins=100 * tests["wins"]).iterrows():
        table.add_row(*(text(row[c.name], c) for c in columns))
    return table


def _empty(columns: Sequence[Column], caption: str) -> "Table":
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, caption=caption, caption_justify="left", pad_edge=False)
    for column in columns:
        table.add_column(column.title, justify="left" if column.digits is None else "right", no_wrap=True)
    return table

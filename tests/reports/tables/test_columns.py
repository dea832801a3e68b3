import numpy as np

from reports.tables.columns import LEADERBOARD, STABILITY, Column, best_cells, cell_text, filled_columns
from tests.reports.tables.small import COLUMNS, SMALL


def test_best_values_of_groups_are_marked_ties_share_and_equal_values_have_none():
    assert best_cells(SMALL, COLUMNS, ["g"]) == {(0, "low"), (1, "low"), (1, "high")}


def test_cells_have_their_digits_and_missing_values_a_dash():
    assert cell_text(1.26, Column("x", "x", 1)) == "1.3"
    assert cell_text(float("nan"), Column("x", "x", 1)) == "–"
    assert cell_text(None, Column("x", "x")) == "–"


def test_columns_without_a_value_are_left_out():
    empty = SMALL.assign(low=np.nan)
    assert [column.name for column in filled_columns(COLUMNS, empty)] == ["name", "high"]


def test_errors_of_different_operators_are_not_ranked():
    assert not [
        c.title
        for c in (*LEADERBOARD, *STABILITY)
        if c.name.startswith("eq18") and c.best and c.name != "eq18_relative"
    ]

import re

import numpy as np
import pandas as pd
import pytest

from evaluation.results.store import ResultsStore
from reports.page.headline import headline, overall
from reports.tables import terminal
from reports.tables.columns import GROUP, LEADERBOARD, best_cells, filled_columns
from reports.tables.completeness import unmatched, unranked
from reports.tables.leaderboard import leaderboard, with_numpy_types
from reports.tables.statistics import paired_tests


def rows(method, errors, matched=1.0, regime="r"):
    return [
        {"kind": "matching", "dataset": "d", "regime": regime, "source_pose": "rest", "target_pose": f"p{i}"}
        | {"seed": 0, "method": method, "geodesic_mean": error, "matched": matched, "geodesic_median": error}
        | {"pck_auc": 0.5, "flipped": False, "overlap": 1.0, "source_missing": 0.1, "target_missing": 0.1}
        | {"operator": "heat", "source_threshold": 0.5, "views": "6"}
        for i, error in enumerate(errors)
    ]


@pytest.fixture
def sly():
    """Of three methods one leaves out nearly everything, and one lacks the maps that are hard."""
    hard = [5.0, 6.0, 5.0, 7.0, 6.0, 5.0, 30.0, 40.0]
    return pd.DataFrame(
        [
            *rows("fair", hard),
            *rows("silent", [0.7] * 8, 0.02),
            *rows("absent", [4.0] * 6),
            *rows("poor", [50.0] * 8),
        ]
    )


def test_reasons_name_what_is_lacking(sly):
    assert unranked(sly) == {"silent": "matches 2 % of the points", "absent": "lacks 2 of 8 maps"}
    assert unmatched(sly) == {"silent": "matches 2 % of the points"}
    nearly = pd.DataFrame([*rows("fair", [1.0]), *rows("nearly", [1.0], 0.989), *rows("whole", [1.0], 0.991)])
    assert unranked(nearly) == {"nearly": "matches 98.9 % of the points"}


def test_one_bad_regime_is_enough():
    table = pd.DataFrame([*rows("a", [1.0] * 9), *rows("a", [1.0], 0.5, "hard"), *rows("b", [1.0] * 9)])
    assert unmatched(table) == {"a": "matches 50 % of the points"}
    assert unranked(table)["b"] == "lacks 1 of 10 maps"


def test_incomplete_maps_come_last_are_marked_and_never_the_best(sly):
    board = leaderboard(sly)
    assert board["method"].tolist() == ["fair", "poor", "silent", "absent"]
    assert board["note"].tolist() == [None, None, "matches 2 % of the points", "lacks 2 of 8 maps"]
    assert board["matched"].tolist() == [100, 100, 2, 100]
    best = best_cells(board, filled_columns(LEADERBOARD, board), GROUP)
    assert {board["method"][row] for row, _ in best} == {"fair"}
    assert "note" in {column.name for column in filled_columns(LEADERBOARD, board)}


def test_a_complete_table_has_no_notes(results):
    board = leaderboard(with_numpy_types(ResultsStore(results).table()))
    names = [column.name for column in filled_columns(LEADERBOARD, board)]
    assert "note" not in names
    assert names[names.index("geodesic_mean") + 1] == "matched"  # beside the mean


def test_the_terminal_marks_and_explains_them(sly):
    lines = [re.sub(r"\[/?[a-z]*\]", "", line) for line in terminal.leaderboard_lines(leaderboard(sly), 80)]
    assert "† not ranked: d, r, silent: matches 2 % of the points" in lines
    assert "† not ranked: d, r, absent: lacks 2 of 8 maps" in lines
    assert next(line for line in lines if "silent" in line).split()[:2] == ["silent", "†"]


def test_no_wins_and_no_p_values_by_leaving_points_out(sly):
    tests = paired_tests(sly)
    assert "silent" not in {*tests["first"], *tests["second"]}
    assert tests.set_index(["first", "second"]).loc[("absent", "fair"), "pairs"] == 6  # on what both have
    said = list(terminal.tests_lines(tests, "geodesic_mean", unmatched(sly)))
    assert "not compared: silent: matches 2 % of the points" in said[-1]


def test_the_page_s_headline_is_about_methods_that_can_be_ranked(sly):
    assert [row["method"] for row in overall(sly)] == ["fair", "poor", "silent", "absent"]
    assert overall(sly)[2]["note"] == "matches 2 % of the points"
    assert "The lowest mean geodesic error is that of fair" in headline(sly)
    assert headline(sly[sly["method"] != "poor"]) == ""


def test_a_method_without_any_map_of_a_regime_is_not_ranked_overall(sly):
    table = pd.DataFrame([*rows("fair", [9.0]), *rows("fair", [9.0], 1.0, "hard"), *rows("easy", [1.0])])
    assert [row["method"] for row in overall(table)] == ["fair", "easy"]


def test_tables_of_earlier_versions_do_not_say(sly):
    old = sly.drop(columns="matched")
    assert unmatched(old) == {}
    assert unmatched(sly.assign(matched=np.nan)) == {}

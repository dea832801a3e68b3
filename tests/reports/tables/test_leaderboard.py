import csv
import io

import numpy as np
import pandas as pd
import pytest

from evaluation.results.store import ResultsStore
from reports.tables import leaderboard as tables
from reports.tables.leaderboard import GROUP, LEADERBOARD, Column, best_cells, to_latex, to_markdown


@pytest.fixture(scope="module")
def table(results):
    return tables.plain(ResultsStore(results).table())


def test_plain_tables_hold_numpy_types():
    nullable = pd.DataFrame(
        {
            "a": pd.array([1.5, None], "Float64"),
            "b": pd.array([True, None], "boolean"),
            "c": pd.array(["x", None], "string"),
            "d": pd.array([1, 2], "Int64"),
        }
    )
    plain = tables.plain(nullable)
    assert plain["a"].dtype == float
    assert np.isnan(plain["a"][1])
    assert plain["b"][0] == 1.0
    assert np.isnan(plain["b"][1])
    assert plain["c"][1] is None
    assert plain["d"].dtype == np.int64


def test_leaderboard_has_means_spread_and_ranks(table):
    board = tables.leaderboard(table)
    group = board[(board["dataset"] == "blob") & (board["regime"] == "threshold 0.3")]
    assert list(group["method"]) == ["medial diffusion", "heat kernel"]  # the best first
    first = group.iloc[0]
    assert first["maps"] == 2
    assert first["geodesic_mean"] == pytest.approx(3.5)  # 3 and 4, by seed
    assert first["spread"] == pytest.approx(np.std([3, 4], ddof=1))
    assert first["missing"] == pytest.approx(15)
    assert first["flip_rate"] == 0
    assert group.iloc[1]["flip_rate"] == 100
    assert list(dict.fromkeys(board["dataset"])) == ["blob", "worm"]


def test_methods_that_look_at_the_truth_do_not_compete(table):
    settings = {
        "method": [
            {"name": "truth-landmarks", "label": "medial diffusion"},
            {"name": "heat"},
            {"name": "gone.py:X"},
        ]
    }
    beyond = tables.ceilings(settings)
    assert beyond == {"medial diffusion"}
    board = tables.leaderboard(table, beyond)
    group = board[(board["dataset"] == "blob") & (board["regime"] == "threshold 0.3")]
    assert list(group["method"]) == ["heat kernel", "medial diffusion"]
    assert not any(row in group.index[group["beyond"]] for row, _ in best_cells(board, LEADERBOARD, GROUP))


def test_eq18_comes_from_the_operator_at_the_same_threshold(table):
    board = tables.leaderboard(table).set_index(["dataset", "regime", "method"])["eq18"]
    assert board["blob", "threshold 0.3", "medial diffusion"] == pytest.approx(0.03)
    assert board["blob", "threshold 0.8", "heat kernel"] == pytest.approx(0.32)


def test_stability_averages_poses(table):
    found = tables.stability(table)
    row = found[
        (found["dataset"] == "blob") & (found["operator"] == "heat") & (found["source_threshold"] == 0.8)
    ]
    assert row["eq18"].item() == pytest.approx(0.32)
    assert row["scans"].item() == 4  # two poses, two seeds


def test_empty_tables_stay_empty(table):
    assert tables.leaderboard(table[table["kind"] == "stability"]).empty
    assert tables.stability(table[table["kind"] == "matching"]).empty


COLUMNS = (Column("name", "name & co"), Column("low", "low_1", 1, "low"), Column("high", "±", 2, "high"))
SMALL = pd.DataFrame(
    {
        "g": ["x", "x", "x", "y", "y"],
        "name": ["a|b", "50 % #1", "c", "d", "e"],
        "low": [1.04, 1.0, 2.0, np.nan, 3.0],
        "high": [0.5, 0.9, 0.1, 0.7, 0.7],
    }
)


def test_best_values_of_groups_are_marked_ties_share_and_equal_values_have_none():
    assert best_cells(SMALL, COLUMNS, ["g"]) == {(0, "low"), (1, "low"), (1, "high")}


def test_markdown_is_a_table_with_every_cell():
    lines = to_markdown(SMALL, COLUMNS, ["g"]).splitlines()
    assert lines[0] == "| name & co | low_1 | ± |"
    assert lines[1] == "| --- | ---: | ---: |"
    assert lines[2] == r"| a\|b | **1.0** | 0.50 |"
    assert lines[4] == "| c | 2.0 | 0.10 |"
    assert lines[5] == "| d | – | 0.70 |"


def test_latex_escapes_and_separates_groups():
    text = to_latex(SMALL, COLUMNS, ["g"])
    assert r"name \& co & low\_1 & $\pm$ \\" in text
    assert r"50 \% \#1 & \textbf{1.0} & \textbf{0.90} \\" in text
    assert text.count(r"\midrule") == 2
    assert text.count("&") - text.count(r"\&") == 2 * 6


def test_csv_keeps_full_precision(tmp_path, table):
    board = tables.leaderboard(table)
    paths = tables.write(board, LEADERBOARD, GROUP, tmp_path, "t")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["t.csv", "t.md", "t.tex"]
    rows = list(csv.DictReader(io.StringIO(paths["csv"].read_text())))
    assert len(rows) == len(board)
    assert float(rows[0]["pck_auc"]) == board["pck_auc"][0]

import numpy as np
import pandas as pd
import pytest

from evaluation.results.store import ResultsStore
from reports.tables.columns import GROUP, LEADERBOARD, PARTIAL, best_cells, filled_columns
from reports.tables.leaderboard import ceilings, leaderboard, stability_table, with_numpy_types
from tests.reports.tables.small import partial


@pytest.fixture(scope="module")
def table(results):
    return with_numpy_types(ResultsStore(results).table())


def test_plain_tables_hold_numpy_types():
    nullable = pd.DataFrame(
        {
            "a": pd.array([1.5, None], "Float64"),
            "b": pd.array([True, None], "boolean"),
            "c": pd.array(["x", None], "string"),
            "d": pd.array([1, 2], "Int64"),
        }
    )
    plain = with_numpy_types(nullable)
    assert plain["a"].dtype == float
    assert np.isnan(plain["a"][1])
    assert plain["b"][0] == 1.0
    assert np.isnan(plain["b"][1])
    assert plain["c"][1] is None
    assert plain["d"].dtype == np.int64


def test_leaderboard_has_means_spread_and_ranks(table):
    board = leaderboard(table)
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
    beyond = ceilings(settings)
    assert beyond == {"medial diffusion"}
    board = leaderboard(table, beyond)
    group = board[(board["dataset"] == "blob") & (board["regime"] == "threshold 0.3")]
    assert list(group["method"]) == ["heat kernel", "medial diffusion"]
    assert not any(row in group.index[group["beyond"]] for row, _ in best_cells(board, LEADERBOARD, GROUP))


def test_eq18_comes_from_the_operator_at_the_same_threshold(table):
    board = leaderboard(table).set_index(["dataset", "regime", "method"])["eq18"]
    assert board["blob", "threshold 0.3", "medial diffusion"] == pytest.approx(0.03)
    assert board["blob", "threshold 0.8", "heat kernel"] == pytest.approx(0.32)


def test_stability_averages_poses(table):
    found = stability_table(table)
    row = found[
        (found["dataset"] == "blob") & (found["operator"] == "heat") & (found["source_threshold"] == 0.8)
    ]
    assert row["eq18"].item() == pytest.approx(0.32)
    assert row["scans"].item() == 4  # two poses, two seeds


def test_empty_tables_stay_empty(table):
    assert leaderboard(table[table["kind"] == "stability"]).empty
    assert stability_table(table[table["kind"] == "matching"]).empty


def test_columns_for_scans_that_share_little_are_shown_for_those_only(table):
    board = leaderboard(partial(table))
    little = board["regime"] == "threshold 0.8"
    assert board.loc[little, "excess_mean"].tolist() == pytest.approx(
        (board.loc[little, "geodesic_mean"] - 2).tolist()
    )
    assert set(board.loc[little, "gross_rate"]) == {0.0, 50.0}
    assert board.loc[~little, list(PARTIAL)].isna().all(axis=None)
    assert {column.name for column in filled_columns(LEADERBOARD, board)} >= set(PARTIAL)


def test_tables_of_earlier_versions_have_no_such_columns(table):
    late = ["oracle_mean", "excess_mean", "gross", "right_limb", "mirror_limb", "medial_path_mean", "overlap"]
    late += ["sure_right", "geodesic_best", "alternatives", "probability"]
    board = leaderboard(table.drop(columns=late))
    assert not {column.name for column in filled_columns(LEADERBOARD, board)} & set(PARTIAL)
    assert board["geodesic_mean"].equals(leaderboard(table)["geodesic_mean"])

import numpy as np
import pandas as pd
import pytest

from datasets_gen import InputError
from evaluation.results.store import ResultsStore
from reports.figures.confidence_calibration import BINS, RIGHT, calibration_table
from reports.figures.error_against_missing import seed_band
from reports.figures.failure_rates import rates_of_failure
from reports.figures.result_figures import MAKERS, result_figure, write_result_figure
from reports.figures.runtime_against_size import runtimes
from reports.figures.stage_cost import stage_costs


@pytest.mark.parametrize("name", MAKERS)
def test_figures_of_results_are_written_with_their_numbers(name, results, tmp_path):
    paths = write_result_figure(name, ResultsStore(results), tmp_path)
    assert [path.suffix for path in paths] == [".png", ".pdf", ".csv"]
    assert all(path.stat().st_size > 100 for path in paths)
    assert b"/FontFile2" in paths[1].read_bytes()
    assert len(pd.read_csv(paths[2]))


def test_rates_have_wilson_intervals_and_leave_unknown_maps_out():
    maps = pd.DataFrame({"dataset": "a", "method": "m", "flipped": [True] * 2 + [False] * 8 + [None] * 3})
    row = rates_of_failure(maps).iloc[0]
    assert (row["failed"], row["maps"]) == (2, 10)
    assert (row["low"], row["high"]) == pytest.approx((0.0567, 0.5098), abs=1e-4)  # Newcombe (1998)


def test_calibration_counts_right_matches_by_confidence():
    confidence = np.array([0.05, 0.05, 0.95, 0.95, 1.0, 0.0])
    errors = np.array([0.0, 2 * RIGHT, 1.0, RIGHT, RIGHT, np.nan])
    table = calibration_table({"m": (confidence, errors)})
    assert list(table["low"]) == pytest.approx([0.0, 1 - 1 / BINS])
    assert list(table["points"]) == [3, 3]
    assert list(table["right"]) == pytest.approx([1 / 3, 1.0])


def test_runtimes_are_medians_by_size():
    maps = pd.DataFrame(
        {"method": "m", "n_points": [100, 100, 100, 200], "seconds_match": [1.0, 2.0, 9.0, np.nan]}
    )
    table = runtimes(maps)
    assert table.to_dict("records") == [
        {
            "what": "seconds_match",
            "method": "m",
            "n_points": 100,
            "maps": 3,
            "median": 2.0,
            "low": 1.0,
            "high": 9.0,
        }
    ]


def test_stages_add_up_what_the_records_say(results):
    costs = stage_costs(ResultsStore(results)).set_index("stage")
    assert costs.loc["scan", "tasks"] == 16  # two bodies, poses, thresholds and seeds
    assert costs.loc["scan", "seconds"] == pytest.approx(16 * 2.0)
    assert costs.loc["score", "seconds"] == pytest.approx(16 * 0.1)


def test_bands_hold_the_lines_of_every_seed():
    missing = np.tile(np.linspace(0, 50, 12), 2)
    seeds = np.repeat([0, 1], 12)
    error = np.where(seeds == 0, 1.0, 3.0) + missing / 50
    at, low, high = seed_band(missing, error, seeds)
    assert np.allclose(low, 1 + at / 50)
    assert np.allclose(high, 3 + at / 50)


def test_results_without_maps_are_refused(results, monkeypatch):
    store = ResultsStore(results)
    table = store.table()
    monkeypatch.setattr(store, "table", lambda: table[table["kind"] != "matching"])
    with pytest.raises(InputError, match="holds no maps"):
        result_figure("pck", store)

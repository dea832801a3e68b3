import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reports.tables.statistics import holm, nested_mean, paired_tests, signed_rank, unbeaten


def sweep(errors):
    """Rows of a table: method to its errors on pairs 0, 1, ..."""
    rows = [
        {"kind": "matching", "dataset": "d", "regime": "r", "source_pose": "rest", "target_pose": f"p{i}",
         "seed": 0, "method": method, "geodesic_mean": value}
        for method, values in errors.items()
        for i, value in enumerate(values)
    ]  # fmt: skip
    return pd.DataFrame(rows)


def test_a_method_that_always_wins_is_first_and_significant():
    values = np.linspace(5, 9, 12)
    found = paired_tests(sweep({"worse": values + 1, "better": values})).iloc[0]
    assert (found["first"], found["second"]) == ("better", "worse")
    assert found["difference"] == pytest.approx(1)
    assert (found["wins"], found["ties"]) == (12, 0)
    assert (found["low"], found["high"]) == pytest.approx((1, 1))  # the gap is 1 on every pair
    assert found["p"] == pytest.approx(2 / 2**12)  # the most extreme of all sign patterns, two-sided


def test_few_pairs_say_nothing_about_significance():
    found = paired_tests(sweep({"a": [1, 2, 3], "b": [2, 3, 4]})).iloc[0]
    assert np.isnan(found["p"])
    assert found["pairs"] == 3


def test_only_pairs_that_both_matched_count():
    table = sweep({"a": [1.0, 2, 3], "b": [2.0, 3]})
    assert paired_tests(table).iloc[0]["pairs"] == 2


def test_seeds_are_no_independent_pairs():
    table = pd.concat([sweep({"a": [1.0, 2], "b": [2.0, 3]}).assign(seed=s) for s in range(10)])
    assert paired_tests(table).iloc[0]["pairs"] == 2


def test_regimes_of_a_pair_are_no_independent_pairs():
    easy = sweep({"a": [1.0, 2], "b": [1.5, 3]})
    table = pd.concat([easy, easy.assign(regime="hard", geodesic_mean=easy["geodesic_mean"] * 3)])
    found = paired_tests(table).iloc[0]
    assert found["pairs"] == 2
    assert found["difference"] == pytest.approx((0.5 + 1 + 1.5 + 3) / 4)


def test_seeds_that_one_regime_has_more_of_weigh_no_more():
    maps = sweep({"a": [2.0, 4.0]})
    more = pd.concat([maps, *(maps.assign(regime="hard", seed=s, geodesic_mean=10.0) for s in range(5))])
    assert nested_mean(more, "geodesic_mean") == pytest.approx(((2 + 10) / 2 + (4 + 10) / 2) / 2)


def test_gaps_below_the_digits_of_the_tables_are_ties():
    found = paired_tests(sweep({"a": [1, 1, 1], "b": [1.04, 0.97, 1.2]})).iloc[0]
    assert (found["wins"], found["ties"]) == (1, 2)


def test_nothing_is_unbeaten_where_noise_decides():
    rng = np.random.default_rng(0)
    tables = [sweep({"a": rng.normal(5, 1, 8), "b": rng.normal(5, 1, 8)}) for _ in range(60)]
    decided = [bool(unbeaten(table, {"error": ("geodesic_mean", True)})) for table in tables]
    assert sum(decided) <= 8  # 5 % are to be expected; more than 8 of 60 happen once in 250 times


def test_of_three_methods_the_two_that_cannot_be_told_apart_are_unbeaten():
    base, wobble = np.linspace(4, 7, 8), np.array([0.1, -0.1] * 4)
    table = sweep({"a": base, "b": base + wobble + 0.01, "c": base + 2 + wobble})
    assert unbeaten(table, {"error": ("geodesic_mean", True)}) == {"error": {"a", "b"}}
    assert unbeaten(table, {"score": ("geodesic_mean", False)}) == {"score": {"c"}}


@pytest.mark.parametrize(("pairs", "decided"), [(1, False), (2, False), (5, False), (6, True)])
def test_few_pairs_of_poses_decide_nothing(pairs, decided):
    """The two of the page that a newcomer read had a median of 0.9 and one of 6.4 in bold."""
    errors = {"a": np.linspace(1, 2, pairs), "b": np.linspace(8, 9, pairs), "c": np.linspace(50, 51, pairs)}
    found = unbeaten(sweep(errors), {"error": ("geodesic_mean", True)})
    assert found == ({"error": {"a"}} if decided else {})


def test_one_method_has_nothing_to_be_compared_with():
    assert paired_tests(sweep({"a": [1, 2]})).empty


def test_equal_errors_are_no_difference():
    assert np.isnan(signed_rank(np.zeros(20)))


def test_holm_by_hand():
    assert np.allclose(holm(np.array([0.01, 0.04, 0.03])), [0.03, 0.06, 0.06])


@given(st.lists(st.one_of(st.floats(0, 1), st.just(float("nan"))), max_size=12))
def test_corrected_p_values_are_larger_ordered_and_at_most_one(values):
    p = np.array(values, float)
    corrected = holm(p)
    assert (np.isnan(p) == np.isnan(corrected)).all()
    there = ~np.isnan(p)
    assert (corrected[there] >= p[there]).all()
    assert (corrected[there] <= 1).all()
    order = np.argsort(p[there])
    assert (np.diff(corrected[there][order]) >= 0).all()

import numpy as np
import pandas as pd
import pytest
from scipy.stats import t

from reports.tables.nested_bootstrap import bootstrap_interval, nested_weights, resampled_weights

LEVELS = ["unit", "regime", "seed"]


def full(units, regimes=1, seeds=1):
    rows = [(u, r, s) for u in range(units) for r in range(regimes) for s in range(seeds)]
    return pd.DataFrame(rows, columns=LEVELS)


def test_weights_of_a_full_design_are_equal():
    assert nested_weights(full(3, 2, 4)) == pytest.approx(1 / 24)


def test_weights_of_a_lopsided_design_by_hand():
    cells = pd.DataFrame([(0, 0, 0), (0, 1, 0), (0, 1, 1), (1, 0, 0)], columns=LEVELS)
    assert nested_weights(cells) == pytest.approx([1 / 4, 1 / 8, 1 / 8, 1 / 2])


def test_every_resample_is_a_mean_and_their_mean_is_the_mean():
    cells = full(4, 3, 2).drop(index=[0, 7, 8])
    drawn = resampled_weights(cells, draws=20000)
    assert drawn.sum(axis=1) == pytest.approx(1)
    assert (drawn >= 0).all()
    assert drawn.mean(axis=0) == pytest.approx(nested_weights(cells), abs=0.005)


def test_units_are_resampled_whole():
    """With one regime and seed each, weights are the multinomial counts of the ordinary bootstrap."""
    drawn = resampled_weights(full(5), draws=20000)
    counts = drawn * 5
    assert counts == pytest.approx(np.round(counts))
    assert counts.var(axis=0) == pytest.approx(5 * 0.2 * 0.8, rel=0.05)
    assert np.cov(counts.T)[0, 1] == pytest.approx(-5 * 0.2 * 0.2, rel=0.15)


def test_seeds_of_one_pair_do_not_make_it_more_certain():
    values = np.repeat([1.0, 2.0, 4.0], 6)
    many = resampled_weights(full(3, 2, 3)) @ values
    few = resampled_weights(full(3)) @ np.array([1.0, 2.0, 4.0])
    assert many.std() == pytest.approx(few.std(), rel=0.1)


@pytest.mark.parametrize("units", [3, 8])
def test_for_units_alone_the_interval_is_students(units):
    values = np.random.default_rng(units).normal(size=units)
    drawn = resampled_weights(full(units), draws=50000) @ values
    reach = t.ppf(0.975, units - 1) * values.std(ddof=1) / np.sqrt(units)
    low, high = bootstrap_interval(values.mean(), drawn, units)
    assert (low, high) == pytest.approx((values.mean() - reach, values.mean() + reach), abs=0.03 * reach)


def test_the_interval_holds_the_truth_as_often_as_it_says():
    rng = np.random.default_rng(7)
    cells = full(8, 3, 2)
    weights, drawn = nested_weights(cells), resampled_weights(cells, draws=500)
    held, times = 0, 600
    for _ in range(times):
        values = (
            np.repeat(rng.normal(0, 1, 8), 6) + np.repeat(rng.normal(0, 0.5, 24), 2) + rng.normal(0, 0.3, 48)
        )
        low, high = bootstrap_interval(weights @ values, drawn @ values, 8)
        held += low < 0 < high
    assert 0.92 < held / times < 0.985  # 95 %; the spread of 600 trials is .009, inner levels add a little


def test_one_unit_has_no_interval():
    assert np.isnan(bootstrap_interval(1.0, np.ones(10), 1)).all()

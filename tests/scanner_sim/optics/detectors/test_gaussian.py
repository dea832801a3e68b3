"""The closed form against NumPy's weighted polynomial fit."""

import numpy as np
import pytest

from scanner_sim.optics import peak
from scanner_sim.optics.detectors import gaussian

pytestmark = pytest.mark.uncompiled


def test_it_is_the_weighted_parabola_through_logarithms():
    rng = np.random.default_rng(1)
    x = np.arange(8.0)
    row = 0.8 * np.exp(-(((x - 3.6) / 2) ** 2)) * np.exp(0.05 * rng.standard_normal(8))
    c, b, a = np.polyfit(x, np.log(row), 2, w=row)
    found = peak.fit(row[None], "gaussian")
    assert found.position[0] == pytest.approx(-b / (2 * c))
    assert found.width[0] == pytest.approx(np.sqrt(-1 / c))
    assert found.peak[0] == pytest.approx(np.exp(a - b * b / (4 * c)))


def test_saturated_samples_are_left_out():
    x = np.arange(11.0)
    clipped = np.minimum(2 * np.exp(-(((x - 5.2) / 2) ** 2)), 1)
    found = peak.fit(clipped[None], "gaussian", np.ones(1))
    assert found.position[0] == pytest.approx(5.2, abs=1e-9)
    assert found.width[0] == pytest.approx(2, abs=1e-9)
    assert found.peak[0] == 1
    assert found.residual[0] < 1e-9
    unaware = peak.fit(clipped[None], "gaussian")
    assert abs(unaware.width[0] - 2) > 0.1


def test_a_valley_has_no_peak():
    assert np.isnan(peak.fit(np.array([[0.5, 0.1, 0.5, 0, 0]]), "gaussian").peak[0])


def test_it_is_the_weighted_parabola_through_some_samples():
    """Dark and saturated ones are left out; the others weigh as much as they are bright."""
    rng = np.random.default_rng(2)
    x = np.arange(12.0)
    for _ in range(20):
        row = rng.uniform(0.5, 1) * np.exp(-(((x - rng.uniform(4, 7)) / 2.2) ** 2) + rng.normal(0, 0.1, 12))
        row[rng.integers(12, size=2)] = 0
        ceiling = np.sort(row)[-2]
        kept = (row > 1e-6) & (row < ceiling)
        c, b, a = np.polyfit(x[kept], np.log(row[kept]), 2, w=row[kept])
        expected = (np.exp(a - b * b / (4 * c)), -b / (2 * c), np.sqrt(-1 / c)) if c < 0 else (np.nan,) * 3
        assert gaussian.log_parabola(row, ceiling) == pytest.approx(expected, rel=1e-6, nan_ok=True)


def test_three_samples_that_count_are_enough_and_two_are_not():
    row = np.array([0, 0.3, 0.8, 0.5, 0, 1])
    peak_of, position, width = gaussian.log_parabola(row, 1.0)
    found = peak_of * np.exp(-(((np.arange(1, 4) - position) / width) ** 2))
    assert found == pytest.approx(row[1:4])
    assert np.isnan(gaussian.log_parabola(row, 0.8)).all()


def test_samples_that_count_are_above_the_floor_and_below_the_ceiling():
    assert [gaussian.counts(value, 0.9) for value in (0.0, 1e-6, 2e-6, 0.89, 0.9, 1.0)] == [
        False, False, True, True, False, False,
    ]  # fmt: skip


@pytest.mark.parametrize("dip", [0.1, 0.4, 0.499])
def test_a_valley_however_shallow_has_neither_peak_nor_place(dip):
    assert np.isnan(gaussian.log_parabola(np.array([0.5, dip, 0.5]), 1.0)).all()

"""The systematic error of a truncated centre of mass is that of the mean of a truncated normal law."""

import numpy as np
import pytest
from scipy import stats

from scanner_sim.optics import peak
from scanner_sim.optics.detectors.centre_of_mass import centre_of_mass, located

pytestmark = pytest.mark.uncompiled


@pytest.mark.parametrize("size", [5, 8])
def test_truncation_draws_it_towards_the_largest_sample(size):
    x, deviation = np.arange(41.0), 4.0
    for shift in (-0.4, 0.1, 0.3):
        row = np.exp(-0.5 * ((x - 20 - shift) / deviation) ** 2)
        edges = np.array([-size - 0.5 - shift, size + 0.5 - shift]) / deviation
        expected = shift + stats.truncnorm(*edges, scale=deviation).mean()
        found = centre_of_mass(row, 20 - size, 20 + size) - 20
        assert found == pytest.approx(expected, abs=0.02 * abs(shift))
        assert abs(found) < abs(shift)


def test_the_window_leaves_a_hundredth_of_a_sample():
    """It spans at least 2.5 widths on both sides, beyond which there is .04 % of a Gaussian."""
    for width in (1.3, 2.0, 4.0):
        place = np.linspace(19.5, 20.5, 101)
        rows = np.exp(-(((np.arange(41.0) - place[:, None]) / width) ** 2))
        assert np.abs(peak.fit(rows, "centre_of_mass").position - place).max() < 0.01


def test_light_outside_the_window_is_not_seen():
    row = np.exp(-(((np.arange(30.0) - 8.2) / 1.5) ** 2))
    beside = row + 0.3 * np.exp(-(((np.arange(30.0) - 24) / 1.5) ** 2))
    got, expected = (peak.fit(each[None], "centre_of_mass").position[0] for each in (beside, row))
    assert got == pytest.approx(expected, abs=1e-6)


def test_it_is_the_weighted_mean_by_hand():
    """(1 x 0.2 + 2 x 0.9 + 3 x 0.4) / 1.5, of all samples and of some."""
    row = np.array([0, 0.2, 0.9, 0.4, 0])
    assert centre_of_mass(row, 0, 4) == pytest.approx(3.2 / 1.5)
    assert centre_of_mass(row, 2, 3) == pytest.approx((1.8 + 1.2) / 1.3)
    assert centre_of_mass(row, -3, 9) == pytest.approx(3.2 / 1.5)


def test_the_window_is_one_and_a_half_widths_beside_the_plateau():
    """Of a plateau of two there are two samples of half the height: three on either side of it count."""
    row = np.array([0.4, 0.3, 0.1, 0.1, 0.2, 0.9, 0.9, 0.3, 0.1, 0.05, 0.4])
    assert located(row) == pytest.approx((row * np.arange(11))[2:10].sum() / row[2:10].sum())
    assert np.isnan(located(np.array([0, 0.9, 0.9, 0, 0])))
    assert located(np.array([0, 0.5, 0.9, 0.5, 0])) == pytest.approx(2)

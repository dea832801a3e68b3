"""The closed form against NumPy's weighted polynomial fit."""

import numpy as np
import pytest

from scanner_sim.optics import peak


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

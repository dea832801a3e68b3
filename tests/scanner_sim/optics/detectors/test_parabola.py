"""The parabola's peak locking against its closed form on a Gaussian."""

import numpy as np
import pytest

from scanner_sim.optics import peak
from scanner_sim.optics.detectors import parabola

pytestmark = pytest.mark.uncompiled


@pytest.mark.parametrize("width", [1.0, 1.275, 2.0])
def test_peak_locking_is_the_analytic_curve(width):
    """Samples q e^(-+2 d / s^2) beside the middle, q = exp(-1 / s^2), in (l - r) / (2 (l - 2 m + r))."""
    shift = np.linspace(-0.49, 0.49, 99)
    rows = np.exp(-(((np.arange(11.0) - 5 - shift[:, None]) / width) ** 2))
    q, a = np.exp(-1 / width**2), 2 * shift / width**2
    expected = q * np.sinh(a) / (2 * (1 - q * np.cosh(a)))
    assert np.allclose(peak.fit(rows, "parabola").position - 5, expected, atol=1e-12)


def test_it_is_exact_on_parabolas():
    x, place = np.arange(11.0), np.linspace(4.6, 5.4, 9)
    rows = np.maximum(1 - 0.03 * (x - place[:, None]) ** 2, 0)
    found = peak.fit(rows, "parabola")
    assert np.allclose(found.position, place)
    assert np.allclose(found.peak, 1)


def test_vertex_by_hand():
    """Of y = 2 - (x - 1/4)^2 at -1, 0 and 1; and of three samples by Lagrange's parabola."""
    assert parabola.vertex(2 - 1.25**2, 2 - 0.25**2, 2 - 0.75**2) == pytest.approx(0.25)
    c, b, _ = np.polyfit([-1, 0, 1], [0.3, 0.9, 0.7], 2)
    assert parabola.vertex(0.3, 0.9, 0.7) == pytest.approx(-b / (2 * c))


def test_a_plateau_has_its_peak_in_the_middle_and_two_samples_none():
    assert parabola.located(np.array([0, 0.2, 0.9, 0.9, 0.9, 0.4])) == 3
    assert parabola.located(np.array([0, 0.9, 0.9, 0.4, 0])) == 1.5
    assert np.isnan(parabola.located(np.array([0, 0.9, 0.4, 0, 0])))
    assert parabola.located(np.array([0, 0.2, 0.9, 0.2])) == 2

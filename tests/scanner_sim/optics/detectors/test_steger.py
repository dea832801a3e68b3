"""The Taylor polynomial of a smoothed Gaussian has a maximum that is known in closed form."""

import numpy as np
import pytest

from scanner_sim.optics import peak
from scanner_sim.optics.detectors import steger


@pytest.mark.parametrize("width", [1.275, 2.0, 3.0])
def test_offset_is_that_of_the_smoothed_gaussian(width):
    """Variances of signal, smoothing and sample add to S^2; then -r' / r'' = d / (1 - d^2 / S^2)."""
    sigma = 1.2
    total = width**2 / 2 + sigma**2 + 1 / 12
    for d in (0.1, 0.3, 0.45):
        row = np.exp(-(((np.arange(31.0) - 15 - d) / width) ** 2))
        assert steger.offset(row, 15, sigma) == pytest.approx(d / (1 - d * d / total), rel=2e-3)


def test_the_bias_vanishes_on_samples_and_between_them():
    place = np.array([12.0, 12.5])
    rows = np.exp(-(((np.arange(25.0) - place[:, None]) / 2) ** 2))
    assert np.allclose(peak.fit(rows, "steger").position, place, atol=1e-9)


def test_the_bias_is_the_rest_of_the_taylor_series():
    """d^3 / S^2 to the first order."""
    shift = np.linspace(-0.4, 0.4, 17)
    rows = np.exp(-(((np.arange(25.0) - 12 - shift[:, None]) / 2) ** 2))
    total = 2 + steger.smoothing(rows[8], 12) ** 2 + 1 / 12
    expected = shift / (1 - shift**2 / total)
    assert np.allclose(peak.fit(rows, "steger").position - 12, expected, atol=5e-3)


def test_smoothing_is_the_deviation_of_the_peak():
    for width in (3.0, 6.0):
        row = np.exp(-(((np.arange(61.0) - 30.2) / width) ** 2))
        assert steger.smoothing(row, 30) == pytest.approx(width / np.sqrt(2), rel=0.1)


def test_where_the_smoothed_signal_is_not_concave_there_is_no_offset():
    row = np.array([1.0, 0.6, 0.36, 0.2, 0.1, 0.05, 0.02])
    assert np.isnan(steger.offset(row, 4, 1.0))

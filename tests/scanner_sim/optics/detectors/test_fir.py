"""The derivative filter against the definition of [BR86] and a linear edge."""

import numpy as np
import pytest

from scanner_sim.optics import peak
from scanner_sim.optics.detectors import fir


def slow(row, order):
    """Zero crossing by convolution."""
    half = order // 2
    kernel = np.concatenate([-np.ones(half), [0], np.ones(half)])
    padded = np.pad(row, half + 1)
    filtered = np.convolve(padded, kernel, "same")  # at x: sum of f(x - k) less sum of f(x + k)
    crossings = np.flatnonzero((filtered[:-1] <= 0) & (filtered[1:] > 0))
    x = crossings[np.argmin(np.abs(crossings - half - 1 - row.argmax()))]
    return x - half - 1 + filtered[x] / (filtered[x] - filtered[x + 1])


@pytest.mark.parametrize(("width", "order"), [(1.3, 4), (4.0, 8)])
def test_it_is_the_zero_crossing_of_the_filtered_signal(width, order):
    place = np.linspace(12.05, 12.95, 19)
    rows = np.exp(-(((np.arange(25.0) - place[:, None]) / width) ** 2))
    found = peak.fit(rows, "fir").position
    assert np.allclose(found, [slow(row, order) for row in rows], atol=1e-12)


def test_the_derivative_of_a_ramp_is_its_slope_times_the_filter_gain():
    """2 (1 + 2) for order 4, 2 (1 + 2 + 3 + 4) for order 8, negative where intensities rise."""
    ramp = 0.01 * np.arange(1.0, 20)
    assert fir.derivative(ramp, 9, 4) == pytest.approx(-0.06)
    assert fir.derivative(ramp, 9, 8) == pytest.approx(-0.20)


def test_a_peak_at_the_end_of_the_row_is_found():
    rows = np.zeros((2, 6))
    rows[0, :3] = 0.9, 0.6, 0.2
    rows[1, -3:] = 0.2, 0.6, 0.9
    found = peak.fit(rows, "fir").position
    assert found[0] == pytest.approx(5 - found[1])
    assert -1 <= found[0] <= 1

"""The derivative filter against the definition of [BR86] and a linear edge."""

import numpy as np
import pytest

from scanner_sim.optics import peak
from scanner_sim.optics.detectors import fir

pytestmark = pytest.mark.uncompiled


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


@pytest.mark.parametrize("count", [2, 3, 4, 5, 6, 7])
def test_the_order_goes_by_the_width_at_half_the_height(count):
    """Of bars of up to four samples order 4, of wider ones order 8; flanks of all kinds beside them."""
    rng = np.random.default_rng(count)
    for _ in range(5):
        row = np.zeros(26)
        row[8 : 8 + count] = rng.uniform(0.6, 1, count)
        row[[6, 7, 8 + count, 9 + count]] = rng.uniform(0, 0.25, 4)
        top = int(row.argmax())
        order = 4 if count <= 4 else 8
        assert fir.located(row) == pytest.approx(fir.crossing(row, top, order))
        assert fir.crossing(row, top, order) == pytest.approx(slow(row, order), abs=1e-9)
    assert np.isnan(fir.located(np.array([0, 0.9, 0.8, 0, 0])))
    assert fir.located(np.array([0, 0, 0, 0.4, 0.9, 0.9, 0.4, 0, 0, 0])) == pytest.approx(4.5)


@pytest.mark.parametrize("height", [0.05, 0.1, 0.3, 0.44])
def test_a_peak_with_one_long_flank_lies_beside_its_largest_sample(height):
    """The derivative is positive at the largest sample itself, by the flank before it."""
    row = np.array([0, 0, 0, 0, height, height, 0.9, 0, 0, 0, 0])
    assert fir.derivative(row, 6, 4) == pytest.approx(2 * height)
    for each, place in ((row, slow(row, 4)), (row[::-1], 10 - slow(row, 4))):
        assert fir.crossing(each, int(each.argmax()), 4) == pytest.approx(place)

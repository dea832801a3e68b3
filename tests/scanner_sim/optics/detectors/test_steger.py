"""The Taylor polynomial of a smoothed Gaussian has a maximum that is known in closed form."""

import numpy as np
import pytest

from scanner_sim.optics import peak
from scanner_sim.optics.detectors import steger

pytestmark = pytest.mark.uncompiled


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


def test_offset_is_that_of_integrated_derivatives_of_a_gaussian():
    """r' and r'' by quadrature of the kernel's derivatives over each sample."""
    row, sigma = np.array([0.1, 0.3, 0.9, 0.8, 0.35, 0.0, 0.1]), 1.3
    for x in (2, 3):
        slope = bend = 0.0
        for k, value in enumerate(row):
            u = x - (k + (np.arange(2000) + 0.5) / 2000 - 0.5)  # from the sample's light to x
            kernel = np.exp(-0.5 * (u / sigma) ** 2)
            slope += value * (-u / sigma**2 * kernel).mean()
            bend += value * ((u**2 / sigma**4 - 1 / sigma**2) * kernel).mean()
        assert steger.offset(row, x, sigma) == pytest.approx(-slope / bend, rel=1e-5)


def test_smoothing_is_the_full_width_over_its_deviations():
    """Three samples are at least half as bright as the top: 3 / sqrt(8 ln 2)."""
    assert steger.smoothing(np.array([0.2, 0.45, 0.9, 0.6, 0.1]), 2) == pytest.approx(3 / 2.3548, rel=1e-4)


def test_the_place_is_the_offset_from_the_nearest_sample():
    """From the largest sample, beside which the maximum may lie, to the one that it is nearest to."""
    rng = np.random.default_rng(0)
    moved = 0
    for _ in range(60):
        row = np.concatenate([[0, 0], rng.uniform(0.2, 1, 6), [0, 0]])
        found, sigma = steger.located(row), steger.smoothing(row, int(row.argmax()))
        if np.isnan(found):
            continue
        x = int(np.round(found))
        near = [steger.offset(row, each, sigma) for each in (x - 1, x, x + 1)]
        if abs(near[1]) <= 0.5:
            assert found == pytest.approx(x + near[1])
            moved += x != row.argmax()
        else:  # both place it beyond their middle
            low = int(np.floor(found))
            a, b = (steger.offset(row, each, sigma) for each in (low, low + 1))
            assert found == pytest.approx(low + a / (a - b))
    assert moved > 3
    assert np.isnan(steger.located(np.array([0, 0.9, 0.8, 0, 0])))
    assert steger.located(np.array([0, 0.4, 0.9, 0.9, 0.4, 0])) == pytest.approx(2.5)


@pytest.mark.parametrize(
    "row", [[0.593, 0.555, 0.067, 0.201], [0.516, 0.194, 0.039, 0.56, 0.322, 0.134, 0.282, 0.811]]
)
def test_between_neighbours_that_both_point_beyond_their_middle_offsets_are_interpolated(row):
    """Towards either side: 0 on the line through the offset of one and that of the other."""
    for each in (np.pad(row, 2), np.pad(row, 2)[::-1]):
        top = int(each.argmax())
        sigma = steger.smoothing(each, top)
        low = top if steger.offset(each, top, sigma) > 0 else top - 1
        a, b = (steger.offset(each, x, sigma) for x in (low, low + 1))
        assert a > 0.5
        assert b < -0.5
        assert steger.located(each) == pytest.approx(low + np.interp(0, [b, a], [1, 0]))


@pytest.mark.parametrize(
    "row",
    [
        [0.524, 0.87, 0.028, 0.758, 0.237, 0.189, 0.991],
        [0.885, 0.066, 0.189, 0.612, 0.771, 0.581, 0.184, 0.121],
    ],
)
def test_where_offsets_grow_on_the_way_there_is_no_peak(row):
    """The smoothed signal bends away before it has a maximum."""
    for each in (np.pad(row, 2), np.pad(row, 2)[::-1]):
        assert np.isnan(steger.located(each))


def test_three_samples_are_enough():
    assert steger.located(np.array([0, 0.4, 0.9, 0.4, 0])) == pytest.approx(2)

"""Gaussian fits against their definition and against SciPy's least squares."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import curve_fit

from scanner_sim.optics import peak


def gaussian(x, height, position, width):
    return height * np.exp(-(((x - position) / width) ** 2))


@given(st.floats(0.01, 1), st.floats(3.5, 6.5), st.floats(0.8, 3))
@settings(max_examples=60, deadline=None)
def test_exact_gaussians_are_recovered_by_both_fits(height, position, width):
    values = gaussian(np.arange(10.0), height, position, width)[None]
    for method in ("closed", "iterative"):
        found = peak.fit(values, method)
        got = (found.peak[0], found.position[0], found.width[0])
        assert np.allclose(got, (height, position, width), rtol=1e-4)
        assert found.residual[0] < 1e-4


def test_iterative_fit_is_the_least_squares_solution():
    rng = np.random.default_rng(0)
    x = np.arange(9.0)
    values = gaussian(x, 0.7, 4.3, 1.8) + 0.03 * rng.standard_normal((40, 9))
    values = np.clip(values, 0, 1)
    found = peak.fit(values, "iterative")
    for i, row in enumerate(values):
        used = row > peak.FLOOR
        best, _ = curve_fit(gaussian, x[used], row[used], p0=(0.7, 4.3, 1.8))
        got = (found.peak[i], found.position[i], found.width[i])
        assert np.allclose(got, (best[0], best[1], abs(best[2])), rtol=1e-3)


def test_closed_fit_is_the_weighted_parabola_through_logarithms():
    rng = np.random.default_rng(1)
    x = np.arange(8.0)
    row = gaussian(x, 0.8, 3.6, 2.0) * np.exp(0.05 * rng.standard_normal(8))
    c, b, a = np.polyfit(x, np.log(row), 2, w=row)
    found = peak.fit(row[None], "closed")
    assert found.position[0] == pytest.approx(-b / (2 * c))
    assert found.width[0] == pytest.approx(np.sqrt(-1 / c))
    assert found.peak[0] == pytest.approx(np.exp(a - b * b / (4 * c)))


def test_too_few_samples_or_no_peak_give_nan():
    rows = np.zeros((4, 9))
    rows[1, 4] = 0.5
    rows[2, 4:6] = 0.5
    rows[3, :3] = [0.5, 0.1, 0.5]  # a valley
    for method in ("closed", "iterative"):
        found = peak.fit(rows, method)
        assert np.isnan(found.peak).all()
        assert np.isnan(found.residual).all()


def test_empty_input_gives_empty_output():
    assert len(peak.fit(np.zeros((0, 9))).peak) == 0


def test_shifting_the_samples_shifts_the_position_alone():
    rng = np.random.default_rng(2)
    row = gaussian(np.arange(9.0), 0.6, 4.2, 1.5) * rng.uniform(0.9, 1, 9)
    shifted = np.zeros((2, 14))
    shifted[0, :9] = row
    shifted[1, 5:] = row
    found = peak.fit(shifted)
    assert found.position[1] - found.position[0] == pytest.approx(5)
    assert found.width[1] == pytest.approx(found.width[0])


@pytest.mark.parametrize("bits", [0, 8])
def test_both_fits_agree_on_quantised_peaks_and_the_closed_one_is_no_worse_on_speckle(bits):
    """The comparison of the two fits: equal without noise, closed ahead with it."""
    rng = np.random.default_rng(3)
    x = np.arange(9.0)
    true = rng.uniform(3.5, 4.5, 5000)
    clean = gaussian(x, rng.uniform(0.3, 1, (5000, 1)), true[:, None], 1.8)
    levels = 2**bits - 1
    quantised = np.round(clean * levels) / levels if bits else clean
    error = {m: np.std(peak.fit(quantised, m).position - true) for m in ("closed", "iterative")}
    assert error["closed"] < 1.2 * error["iterative"] + 1e-6
    noise = np.minimum(clean, 0.1) * np.exp(-2 * rng.standard_normal(clean.shape) ** 2)
    speckled = {m: np.nanstd(peak.fit(clean - noise, m).position - true) for m in ("closed", "iterative")}
    assert speckled["closed"] < 1.05 * speckled["iterative"]

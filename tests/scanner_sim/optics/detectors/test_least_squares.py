"""Least squares against SciPy, clipped Gaussians, and the Cramer-Rao bound."""

import numpy as np
import pytest
from scipy.optimize import curve_fit

from scanner_sim.optics import peak


def gaussian(x, height, position, width):
    return height * np.exp(-(((x - position) / width) ** 2))


def bound(x, height, position, width, sigma):
    """Cramer-Rao bound of the position's deviation: Fisher information of white noise, all three unknown."""
    u = (x - position) / width
    e = np.exp(-u * u)
    j = np.stack([e, 2 * height * e * u / width, 2 * height * e * u * u / width], axis=1)
    return sigma * np.sqrt(np.linalg.inv(j.T @ j)[1, 1])


@pytest.mark.uncompiled
def test_it_is_the_least_squares_solution():
    rng = np.random.default_rng(0)
    x = np.arange(9.0)
    values = np.clip(gaussian(x, 0.7, 4.3, 1.8) + 0.03 * rng.standard_normal((40, 9)), 0, 1)
    found = peak.fit(values, "least_squares", np.ones(40))
    for i, row in enumerate(values):
        used = row > peak.FLOOR
        best, _ = curve_fit(gaussian, x[used], row[used], p0=(0.7, 4.3, 1.8))
        got = (found.peak[i], found.position[i], found.width[i])
        assert np.allclose(got, (best[0], best[1], abs(best[2])), rtol=1e-3)


@pytest.mark.uncompiled
@pytest.mark.parametrize("exposure", [1.2, 2.0, 4.0])
def test_clipped_gaussians_are_recovered(exposure):
    x, place = np.arange(13.0), np.linspace(5.5, 6.5, 41)
    clipped = np.minimum(gaussian(x, exposure, place[:, None], 2), 1)
    found = peak.fit(clipped, "least_squares", np.ones(41))
    assert np.abs(found.position - place).max() < 1e-3
    assert np.abs(found.width - 2).max() < 1e-3
    assert (found.peak == 1).all()
    assert found.residual.max() < 1e-3


def test_fitting_the_saturated_samples_would_be_wrong():
    x, place = np.arange(13.0), np.linspace(5.5, 6.5, 41)
    unaware = peak.fit(np.minimum(gaussian(x, 2, place[:, None], 2), 1), "least_squares")
    assert np.abs(unaware.width - 2).min() > 0.2
    assert np.abs(unaware.position - place).max() > 1e-3
    assert unaware.peak.min() > 1


def test_clipped_and_noisy_gaussians_are_recovered_without_bias():
    """The mean error is within 4 of its standard errors of 0; with the samples fitted, widths are not."""
    rng = np.random.default_rng(1)
    x, place = np.arange(13.0), rng.uniform(5.5, 6.5, 20_000)
    values = np.minimum(gaussian(x, 2, place[:, None], 2) + 0.01 * rng.standard_normal((20_000, 13)), 1)
    found = peak.fit(values, "least_squares", np.ones(20_000))
    error = found.position - place
    assert abs(error.mean()) < 4 * error.std() / np.sqrt(len(error))
    assert found.width.mean() == pytest.approx(2, rel=0.005)


@pytest.mark.parametrize("sigma", [0.003, 0.01])
def test_the_position_reaches_the_cramer_rao_bound(sigma):
    rng = np.random.default_rng(2)
    x, place = np.arange(11.0), rng.uniform(4.5, 5.5, 20_000)
    values = gaussian(x, 1, place[:, None], 1.5) + sigma * rng.standard_normal((20_000, 11))
    error = peak.fit(values, "least_squares").position - place
    best = np.sqrt(np.mean([bound(x, 1, each, 1.5, sigma) ** 2 for each in place[:500]]))
    assert error.std() == pytest.approx(best, rel=0.1)


@pytest.mark.uncompiled
def test_three_unknowns_need_three_samples_that_are_not_saturated():
    row = np.array([[0.1, 1, 1, 1, 0.1, 0, 0]])
    assert np.isnan(peak.fit(row, "least_squares", np.ones(1)).peak[0])
    assert np.isfinite(peak.fit(row, "least_squares").peak[0])


@pytest.mark.uncompiled
def test_where_the_logarithms_have_no_maximum_it_starts_from_the_moments():
    """Speckle took the right flank: the parabola opens upwards, the intensities still have a peak."""
    row = np.array([[0, 0, 0.01, 0, 0.09, 0.28, 0, 0, 0]])
    assert np.isnan(peak.fit(row, "gaussian").peak[0])
    found = peak.fit(row, "least_squares")
    assert 4.5 < found.position[0] < 5.5
    assert found.width[0] < 2


@pytest.mark.uncompiled
def test_a_valley_has_no_peak():
    assert np.isnan(peak.fit(np.array([[0.5, 0.1, 0.5]]), "least_squares").peak[0])

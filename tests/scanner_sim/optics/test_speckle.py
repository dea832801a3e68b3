"""Statistics of multiplicative speckle against Goodman's theory; seeds are fixed, so results are too."""

import numpy as np
import pytest
from scipy import stats

from scanner_sim.optics import speckle
from scanner_sim.optics.noise import SampleNoise

LEAST = 1e-3
"""Smallest accepted p-value."""


def grid(columns, rows, stripes, seed=0, view=0):
    """Every pixel of an image under the same stripes."""
    column, row = np.meshgrid(np.arange(columns), np.arange(rows))
    pixels = np.stack([column.ravel(), row.ravel()], axis=1).astype(np.int32)
    return SampleNoise(seed, view, pixels, np.zeros(len(pixels), np.int64), stripes)


def apart(factors, columns, step):
    """Factors of pixels so far apart that they are independent, (k, w)."""
    return factors.reshape(-1, columns, factors.shape[1])[::step, ::step].reshape(-1, factors.shape[1])


def test_fully_developed_speckle_is_exponential():
    """[Goo07, Eq. 3-10]: p(I) = exp(-I) for mean 1."""
    found = apart(speckle.factors(grid(96, 96, 40), 1.0, 1.0), 96, 6).ravel()
    assert stats.kstest(found, "expon").pvalue > LEAST


def test_equal_patterns_add_up_to_a_gamma_distribution():
    """[Goo07, Sec. 3.2.1]: M equal patterns, M = 4 at a contrast of 1/2."""
    found = apart(speckle.factors(grid(96, 96, 20), 0.5, 1.0), 96, 6).ravel()
    assert stats.kstest(found, stats.gamma(4, scale=1 / 4).cdf).pvalue > LEAST


def test_low_contrast_is_the_gamma_distribution_too():
    found = apart(speckle.factors(grid(96, 96, 40), 0.15, 1.0), 96, 6).ravel()
    assert stats.kstest(found, stats.gamma(0.15**-2, scale=0.15**2).cdf).pvalue > LEAST


@pytest.mark.parametrize("contrast", [1.0, 0.8, 0.6, 0.5, 0.3, 0.15, 0.03])
def test_mean_and_contrast(contrast):
    """Within the standard errors of the mean and of the standard deviation over independent samples."""
    found = apart(speckle.factors(grid(64, 64, 40), contrast, 1.0), 64, 5).ravel()
    assert stats.ttest_1samp(found, 1).pvalue > LEAST
    squares = (found - 1) ** 2
    assert stats.ttest_1samp(squares, contrast**2).pvalue > LEAST
    assert found.min() >= 0


@pytest.mark.parametrize("contrast", np.linspace(0.26, 1, 12))
def test_weights_give_mean_and_contrast_exactly(contrast):
    """Variances of independent exponential intensities add up: sum w = 1, sum w^2 = C^2."""
    weights = np.array(speckle.pattern_weights(contrast))
    assert len(weights) == int(np.ceil(contrast**-2 - 1e-9))
    assert weights.min() >= 0
    assert weights.sum() == pytest.approx(1)
    assert (weights**2).sum() == pytest.approx(contrast**2)


@pytest.mark.parametrize(("contrast", "size"), [(1.0, 1.0), (1.0, 2.5), (0.6, 1.5), (0.15, 2.0)])
def test_autocovariance_is_gaussian_and_falls_to_1_over_e_at_the_size(contrast, size):
    """exp(-(d / size)^2) at several distances, within the spread over independent stripes."""
    n, count = 64, 60
    found = speckle.factors(grid(n, n, count), contrast, size).reshape(n, n, count) - 1
    for shift in (1, 2, 3):
        for first, second in ((found[shift:], found[:-shift]), (found[:, shift:], found[:, :-shift])):
            correlation = (first * second).mean(axis=(0, 1)) / contrast**2
            assert stats.ttest_1samp(correlation, np.exp(-((shift / size) ** 2))).pvalue > LEAST


def test_speckle_smaller_than_a_pixel_is_independent_between_pixels():
    found = speckle.factors(grid(60, 60, 4), 1.0, 0.1).reshape(60, 60, 4)
    assert stats.pearsonr(found[1:].ravel(), found[:-1].ravel()).pvalue > LEAST


@pytest.mark.parametrize("lag", [1, 2])
def test_stripes_views_and_seeds_are_independent(lag):
    found = apart(speckle.factors(grid(96, 96, 10), 1.0, 1.0), 96, 6)
    assert stats.pearsonr(found[:, lag:].ravel(), found[:, :-lag].ravel()).pvalue > LEAST
    view = apart(speckle.factors(grid(96, 96, 10, view=1), 1.0, 1.0), 96, 6)
    seed = apart(speckle.factors(grid(96, 96, 10, seed=1), 1.0, 1.0), 96, 6)
    assert stats.pearsonr(found.ravel(), view.ravel()).pvalue > LEAST
    assert stats.pearsonr(found.ravel(), seed.ravel()).pvalue > LEAST


@pytest.mark.uncompiled
def test_a_factor_does_not_depend_on_what_else_is_measured():
    whole = grid(30, 20, 5)
    factors = speckle.factors(whole, 0.7, 1.5)
    rng = np.random.default_rng(0)
    some = rng.permutation(len(whole.pixels))[:50]
    first = rng.integers(0, 3, len(some))
    part = SampleNoise(0, 0, whole.pixels[some], first, 2)
    expected = np.take_along_axis(factors[some], first[:, None] + np.arange(2), axis=1)
    assert np.array_equal(speckle.factors(part, 0.7, 1.5), expected)


@pytest.mark.uncompiled
def test_rows_may_begin_before_the_first_stripe_and_be_none():
    pixel = np.array([[3, 4]], np.int32)
    before, after = (SampleNoise(0, 0, pixel, np.array([first]), 4) for first in (-2, 0))
    found = [speckle.factors(each, 1.0, 1.0)[0] for each in (before, after)]
    assert np.array_equal(found[0][2:], found[1][:2])
    assert len(np.unique(found)) == 6
    none = SampleNoise(0, 0, np.empty((0, 2), np.int32), np.empty(0, np.int64), 4)
    assert speckle.factors(none, 1.0, 1.0).shape == (0, 4)

"""Every noise model against its distribution, by p-values; seeds are fixed, so results are too."""

import numpy as np
import pytest
from scipy import stats

from scanner_sim import ScannerConfig
from scanner_sim.optics import sensor

LEAST = 1e-3
"""Smallest accepted p-value."""


def test_speckle_follows_its_distribution():
    """exp(-2 z^2) <= x where z^2 >= -ln(x) / 2."""
    taken = sensor.speckle(np.full((200, 100), 0.8), 0.3, np.random.default_rng(0)).ravel()
    assert taken.max() <= 0.3
    assert taken.min() >= 0
    assert stats.kstest(taken / 0.3, lambda x: stats.chi2.sf(-np.log(x) / 2, 1)).pvalue > LEAST


def test_speckle_is_bounded_by_the_stripe():
    cast = np.linspace(0, 1, 1000)[None]
    taken = sensor.speckle(cast, 0.35, np.random.default_rng(1))
    assert (taken <= np.minimum(cast, 0.35)).all()


@pytest.mark.parametrize("level", [0.02, 0.4, 0.9])
def test_shot_noise_is_poisson(level):
    counts = sensor.shot(np.full(20_000, level), 500, np.random.default_rng(2)) * 500
    assert np.allclose(counts, np.round(counts))
    mean = 500 * level
    edges = np.unique(stats.poisson.ppf(np.linspace(0.05, 0.95, 10), mean))
    observed = np.histogram(counts, np.concatenate([[-1], edges, [np.inf]]) + 0.5)[0]
    expected = np.diff(np.concatenate([[0], stats.poisson.cdf(edges, mean), [1]])) * len(counts)
    assert stats.chisquare(observed, expected).pvalue > LEAST


def test_read_noise_is_normal():
    config = ScannerConfig(read_noise=0.05, bits=0)
    half = np.full((200, 100), 0.5)
    values = sensor.expose(half, half, config, np.random.default_rng(3)).ravel()
    assert stats.kstest((values - 0.5) / 0.05, "norm").pvalue > LEAST


def test_noise_is_independent_between_samples():
    config = ScannerConfig(read_noise=0.02, bits=0)
    half = np.full((4000, 2), 0.5)
    values = sensor.expose(half, half, config, np.random.default_rng(4))
    assert stats.pearsonr(values[:, 0], values[:, 1]).pvalue > LEAST
    assert stats.pearsonr(values[:-1, 0], values[1:, 0]).pvalue > LEAST


@pytest.mark.parametrize("bits", [1, 8, 12])
def test_quantisation_errs_by_half_a_step_at_most_and_uniformly(bits):
    values = np.random.default_rng(5).random(50_000)
    stored = sensor.quantise(values, bits)
    steps = (stored - values) * (2**bits - 1)
    assert np.abs(steps).max() <= 0.5 + 1e-9
    assert stats.kstest(steps + 0.5, "uniform").pvalue > LEAST


def test_exposure_gain_and_saturation():
    light = np.array([[0.1, 0.2, 0.6]])
    config = ScannerConfig(exposure=2.0, gain=1.5, bits=0)
    assert np.allclose(sensor.expose(light, light, config, np.random.default_rng(0)), [[0.3, 0.6, 1.0]])


def test_gain_amplifies_shot_noise_and_exposure_averages_it():
    light = np.full((300, 100), 0.2)
    rng = np.random.default_rng(6)
    spread = {
        name: np.std(sensor.expose(light, light, ScannerConfig(full_well=1000, bits=0, **setting), rng))
        for name, setting in (("plain", {}), ("gain", {"gain": 2.0}), ("exposure", {"exposure": 2.0}))
    }
    assert spread["gain"] == pytest.approx(2 * spread["plain"], rel=0.03)
    assert spread["exposure"] == pytest.approx(np.sqrt(2) * spread["plain"], rel=0.03)

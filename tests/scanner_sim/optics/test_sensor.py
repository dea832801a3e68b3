"""Every noise model against its distribution, by p-values; seeds are fixed, so results are too."""

import numpy as np
import pytest
from scipy import optimize, stats

from scanner_sim.optics import sensor
from scanner_sim.optics.noise import SampleNoise
from scanner_sim.scanner_config import ScannerConfig

LEAST = 1e-3
"""Smallest accepted p-value."""


def samples(rows, width, seed=0):
    number = np.arange(rows)
    pixels = np.stack([number % 200, number // 200], axis=1).astype(np.int32)
    return SampleNoise(seed, 0, pixels, np.zeros(rows, np.int64), width)


def exposed(light, seed=0, ambient=0.0, **settings):
    light = np.asarray(light, float)
    noise = samples(*light.shape, seed)
    return sensor.expose(light, light, np.full(len(light), ambient), ScannerConfig(**settings), noise)


def test_additive_speckle_follows_its_distribution():
    """exp(-2 z^2) <= x where z^2 >= -ln(x) / 2."""
    normal = samples(200, 100).normal(0)
    taken = sensor.additive_speckle(np.full((200, 100), 0.8), 0.3, normal).ravel()
    assert taken.max() <= 0.3
    assert taken.min() >= 0
    assert stats.kstest(taken / 0.3, lambda x: stats.chi2.sf(-np.log(x) / 2, 1)).pvalue > LEAST


def test_additive_speckle_is_bounded_by_the_stripe():
    cast = np.linspace(0, 1, 1000)[None]
    taken = sensor.additive_speckle(cast, 0.35, samples(1, 1000).normal(0))
    assert (taken <= np.minimum(cast, 0.35)).all()


@pytest.mark.parametrize("level", [0.002, 0.02, 0.4, 0.9])
def test_shot_noise_is_poisson(level):
    counts = sensor.shot(np.full((200, 100), level), 500, samples(200, 100).uniform(1)).ravel() * 500
    assert np.allclose(counts, np.round(counts))
    mean = 500 * level
    edges = np.unique(stats.poisson.ppf(np.linspace(0.05, 0.95, 10), mean))
    observed = np.histogram(counts, np.concatenate([[-1], edges, [np.inf]]) + 0.5)[0]
    expected = np.diff(np.concatenate([[0], stats.poisson.cdf(edges, mean), [1]])) * len(counts)
    assert stats.chisquare(observed, expected).pvalue > LEAST


@pytest.mark.parametrize(
    ("mean", "share"), [(1e-6, 0), (0.3, 0), (9.99, 0), (10.0, 1e-3), (100.0, 1e-4), (2e4, 1e-5)]
)
def test_counts_are_those_of_the_inverse_distribution(mean, share):
    """At evenly spread probabilities and far out in the tails, against scipy's own inverse."""
    ends = 10.0 ** -np.arange(2, 16)
    uniform = np.concatenate([ends, (np.arange(20_000) + 0.5) / 20_000, 1 - ends])
    off = np.abs(sensor.poisson(uniform, np.full_like(uniform, mean)) - stats.poisson.ppf(uniform, mean))
    assert off.max() <= (share > 0)
    assert (off[14:-14] > 0).mean() <= share


def test_no_light_gives_no_counts():
    assert (sensor.shot(np.array([[-0.1, 0.0]]), 1000, np.array([[1 - 1e-16, 1 - 1e-16]])) == 0).all()


def test_read_noise_is_normal():
    values, _ = exposed(np.full((200, 100), 0.5), read_noise=0.05, bits=0)
    assert stats.kstest((values.ravel() - 0.5) / 0.05, "norm").pvalue > LEAST


def test_noise_is_independent_between_samples_and_kinds():
    values, _ = exposed(np.full((4000, 2), 0.5), read_noise=0.02, bits=0)
    assert stats.pearsonr(values[:, 0], values[:, 1]).pvalue > LEAST
    assert stats.pearsonr(values[:-1, 0], values[1:, 0]).pvalue > LEAST
    counted, _ = exposed(np.full((4000, 2), 0.5), full_well=1000, bits=0)
    assert stats.pearsonr(values[:, 0], counted[:, 0]).pvalue > LEAST


@pytest.mark.parametrize("bits", [1, 8, 12])
def test_quantisation_errs_by_half_a_step_at_most_and_uniformly(bits):
    values = np.random.default_rng(5).random(50_000)
    stored = sensor.quantise(values, bits)
    steps = (stored - values) * (2**bits - 1)
    assert np.abs(steps).max() <= 0.5 + 1e-9
    assert stats.kstest(steps + 0.5, "uniform").pvalue > LEAST


def test_truncation_stores_the_level_below():
    """A cast to an integer, floor(255 x), as in the reference: half a level darker in the mean."""
    values = np.random.default_rng(6).random(50_000)
    stored = sensor.quantise(values, 8, "truncate")
    assert np.array_equal(np.round(stored * 255), (values * 255).astype(int))
    assert stats.kstest((values - stored) * 255, "uniform").pvalue > LEAST
    assert sensor.quantise(np.array([1.0, 2.0]), 8, "truncate").tolist() == [1.0, 1.0]


def test_exposure_gain_and_saturation():
    values, ceiling = exposed([[0.1, 0.2, 0.6]], exposure=2.0, gain=1.5, bits=0)
    assert np.allclose(values, [[0.3, 0.6, 1.0]])
    assert ceiling.tolist() == [1.0]


def test_gain_amplifies_shot_noise_and_exposure_averages_it():
    light = np.full((300, 100), 0.2)
    spread = {
        name: np.std(exposed(light, seed, full_well=1000, bits=0, **setting)[0])
        for seed, (name, setting) in enumerate(
            (("plain", {}), ("gain", {"gain": 2.0}), ("exposure", {"exposure": 2.0}))
        )
    }
    assert spread["gain"] == pytest.approx(2 * spread["plain"], rel=0.03)
    assert spread["exposure"] == pytest.approx(np.sqrt(2) * spread["plain"], rel=0.03)


def test_the_dark_frame_is_subtracted_and_lowers_the_ceiling():
    """Dark level .1 and ambient light .05 x 2 x 1.5 = .15 leave .75 of the range."""
    settings = {"exposure": 2.0, "gain": 1.5, "dark_level": 0.1, "bits": 0}
    values, ceiling = exposed([[0.0, 0.1, 0.24, 0.26, 9.0]], ambient=0.05, **settings)
    assert np.allclose(values, [[0.0, 0.3, 0.72, 0.75, 0.75]])
    assert np.allclose(ceiling, 0.75)
    assert (values[0, 3:] == ceiling[0]).all()


def test_a_dark_level_keeps_read_noise_below_zero():
    """Without it the sensor cuts half of the noise off, and the mean of no light is not 0."""
    dark = np.zeros((300, 100))
    cut, _ = exposed(dark, read_noise=0.02, bits=8)
    kept, _ = exposed(dark, read_noise=0.02, dark_level=0.1, bits=8)
    assert cut.mean() == pytest.approx(0.02 / np.sqrt(2 * np.pi), rel=0.05)
    assert stats.ttest_1samp(kept.ravel(), 0).pvalue > LEAST
    assert kept.std() == pytest.approx(np.hypot(0.02, 1 / 255 / np.sqrt(12)), rel=0.02)


def test_ambient_light_adds_its_own_shot_noise():
    """The variance of counting is that of all the light, 0.1 + 0.3, though the mean of 0.3 is taken away."""
    values, _ = exposed(np.full((400, 100), 0.1), ambient=0.3, full_well=2000, bits=0)
    assert stats.ttest_1samp(values.ravel(), 0.1).pvalue > LEAST
    statistic = values.var() / (0.4 / 2000) * values.size
    assert 2 * min(stats.chi2.cdf(statistic, values.size), stats.chi2.sf(statistic, values.size)) > LEAST


def test_a_room_too_bright_leaves_nothing():
    values, ceiling = exposed([[0.5, 1.0]], ambient=2.0)
    assert values.tolist() == [[0.0, 0.0]]
    assert ceiling.tolist() == [0.0]


def test_speckle_multiplies_the_laser_but_not_the_room():
    light = np.zeros((500, 8))
    light[:, :4] = 0.05
    values, _ = exposed(light, ambient=0.2, speckle_contrast=1.0, bits=0)
    assert np.allclose(values[:, 4:], 0)
    assert values[:, :4].std() == pytest.approx(0.05, rel=0.15)


def test_everything_of_the_sensor_by_hand():
    """Exposed twice as long, less speckle, at a gain of 1.5, a dark level of 0.02 and ambient light."""
    light, cast = np.array([[0.1, 0.0, 0.3]]), np.array([[0.5, 0.04, 1.0]])
    config = ScannerConfig(exposure=2.0, noise=0.1, gain=1.5, dark_level=0.02, bits=0)
    noise = samples(1, 3)
    values, ceiling = sensor.expose(light, cast, np.array([0.05]), config, noise)
    taken = np.array([0.1, 0.04, 0.1]) * np.exp(-2 * noise.normal(0)[0] ** 2)
    stored = np.clip(((light[0] + 0.05) * 2 - taken) * 1.5 + 0.02, 0, 1)
    assert values[0] == pytest.approx(stored - 0.17)
    assert ceiling == pytest.approx([0.83])


def test_noise_of_the_sensor_by_hand():
    """Streams of their own: counts of the second, read noise of the third."""
    config = ScannerConfig(full_well=100, read_noise=0.03, dark_level=0.2, bits=0)
    noise = samples(1, 50)
    values, _ = sensor.expose(np.full((1, 50), 0.05), np.ones((1, 50)), np.zeros(1), config, noise)
    counts = stats.poisson.ppf(noise.uniform(1)[0], 5.0) / 100
    assert values[0] == pytest.approx(np.clip(counts + 0.03 * noise.normal(2)[0] + 0.2, 0, 1) - 0.2)


def test_quantisation_by_hand():
    """Two bits have four levels, three steps."""
    values = np.array([-0.1, 0.15, 0.18, 0.49, 0.51, 0.7, 1.2])
    assert sensor.quantise(values, 2) * 3 == pytest.approx([0, 0, 1, 1, 2, 2, 3])
    assert sensor.quantise(values, 2, "truncate") * 3 == pytest.approx([0, 0, 0, 1, 1, 2, 3])
    assert sensor.quantise(values, 0).tolist() == [0, 0.15, 0.18, 0.49, 0.51, 0.7, 1]


def expansion(normal, mean):
    """Q_N2 of [Gil16], as published."""
    root = np.sqrt(mean)
    return (
        mean
        + root * normal
        + (1 / 3 + normal**2 / 6)
        + (-normal / 36 - normal**3 / 72) / root
        + (-8 / 405 + 7 * normal**2 / 810 + normal**4 / 270) / mean
    )


@pytest.mark.parametrize("mean", [10.0, 37.5, 900.0])
def test_many_counts_change_where_the_published_expansion_is_whole(mean):
    for count in np.round(mean + np.sqrt(mean) * np.array([-2.5, -1, 0.3, 1, 2.7])):
        place = optimize.brentq(lambda w, count=count: expansion(w, mean) - count, -4, 4, xtol=1e-14)
        around = stats.norm.cdf(place + np.array([-1e-7, 1e-7]))
        assert sensor.poisson(around, np.full(2, mean)).tolist() == [count - 1, count]


def test_a_count_is_the_smallest_whose_probability_reaches_the_number():
    """Of mean 0.7, no count has the probability exp(-0.7): that number gives none, a larger one gives one."""
    none = np.exp(np.array([-0.7]))
    assert sensor.poisson(none, np.array([0.7])) == 0
    assert sensor.poisson(np.nextafter(none, 1) + 1e-15, np.array([0.7])) == 1

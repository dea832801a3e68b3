"""The formulas of speckle, each against its closed form or a dense sum of few pixels."""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.ndimage import correlate

from scanner_sim.optics import speckle
from scanner_sim.optics.noise import SampleNoise

pytestmark = pytest.mark.uncompiled


@pytest.mark.parametrize(
    ("contrast", "count"),
    [(1.0, 1), (0.99, 2), (math.sqrt(0.5), 2), (0.7, 3), (0.5, 4), (0.3, 12), (0.25, 16)],
)
def test_the_fewest_patterns_whose_sum_has_the_contrast(contrast, count):
    """All but one of equal weight, the last one lighter: sum w = 1, sum w^2 = C^2."""
    weights = speckle.pattern_weights(contrast)
    assert len(weights) == count
    assert sum(weights) == pytest.approx(1)
    assert sum(w * w for w in weights) == pytest.approx(contrast**2)
    assert len(set(weights[:-1])) <= 1
    assert 0 <= weights[-1] <= weights[0] + 1e-9


@pytest.mark.parametrize("contrast", [0.05, 0.2])
def test_gamma_factors_have_the_quantiles_of_the_gamma_distribution(contrast):
    """Wilson and Hilferty's cube root is within a thousandth of them where the contrast is low."""
    share = np.array([0.01, 0.2, 0.5, 0.8, 0.99])
    exact = stats.gamma(contrast**-2, scale=contrast**2).ppf(share)
    assert speckle.gamma_factors(stats.norm.ppf(share), contrast) == pytest.approx(exact, rel=1.5e-3)
    assert speckle.gamma_factors(np.array([-1e3]), contrast) == 0


@pytest.mark.parametrize("width", [0.1, 0.4, 1.0, 1.7, 3.0])
def test_taps_give_noise_the_autocorrelation(width):
    """Of filtered white noise it is the autocorrelation of the taps; what is cut off is a thousandth."""
    taps = speckle.gaussian_taps(width)
    reach = math.ceil(2.5 * width) + 1
    assert len(taps) == 2 * reach + 1
    assert taps == pytest.approx(taps[::-1])
    assert (taps**2).sum() == pytest.approx(1)
    found = np.correlate(taps, taps, "full")[len(taps) - 1 :]
    assert found == pytest.approx(np.exp(-(np.arange(len(taps)) ** 2) / (2 * width**2)), abs=2e-3)


def box_muller(column, row, stripe, key):
    """Of the upper and the lower half of a hash, in whole numbers."""
    most = 2**64 - 1

    def scramble(z):
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 & most
        z = (z ^ (z >> 27)) * 0x94D049BB133111EB & most
        return z ^ (z >> 31)

    place = (row + 65536) << 32 | (column + 65536)
    place = scramble((place + int(key[0])) & most)
    bits = scramble((scramble((place + stripe + 65536) & most) + int(key[1])) & most)
    radius = math.sqrt(-2 * math.log(((bits >> 32) + 0.5) / 2**32))
    angle = 2 * math.pi * (bits & 0xFFFFFFFF) / 2**32
    return complex(radius * math.cos(angle), radius * math.sin(angle))


KEY = np.random.SeedSequence(3).generate_state(2, np.uint64)


@pytest.mark.filterwarnings("ignore:overflow")
def test_white_noise_is_that_of_box_and_muller():
    for place in ((0, 0, 0), (5, -3, 7), (-40, 399, 1200), (17, 17, -2)):
        assert speckle._white(*place, KEY) == pytest.approx(box_muller(*place, KEY), rel=1e-12)


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize("size", [1, 2])
def test_a_stripe_is_filtered_along_rows_and_columns(size):
    """Against a dense correlation of the noise of the whole window; scattered pixels, one of them alone."""
    taps = np.random.default_rng(0).normal(size=2 * size + 1)
    pixels = np.array([[3, 2], [9, 9], [5, 2], [4, 6], [12, 5], [3, 7]])
    members = np.array([0, 2, 3, 4, 5])
    out = np.full(8, np.nan, complex)
    places = np.array([6, 1, 0, 3, 4])
    speckle._filter_stripe(pixels, members, places, 11, KEY, taps, out)
    white = np.array([[box_muller(x, y, 11, KEY) for x in range(-3, 20)] for y in range(-3, 16)])
    kernel = np.outer(taps, taps)
    dense = correlate(white.real, kernel) + 1j * correlate(white.imag, kernel)
    for member, place in zip(members, places, strict=True):
        column, row = pixels[member]
        assert out[place] == pytest.approx(dense[row + 3, column + 3], rel=1e-9)
    assert np.isnan(out[[2, 5, 7]]).all()


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize("contrast", [1.0, 0.8, 0.1])
def test_factors_by_loops(contrast):
    """Weighted sums of |a|^2 / 2 of each pattern's field, its parts of unit variance; or gamma factors."""
    noise = SampleNoise(7, 1, np.array([[3, 4], [5, 4], [4, 6]], np.int32), np.array([2, 0, 1]), 3)
    size = 0.9
    weights = speckle.pattern_weights(contrast) if contrast > 0.25 else [1.0]
    width = size if contrast > 0.25 else size / math.sqrt(2)
    taps = speckle.gaussian_taps(width)
    reach = len(taps) // 2
    expected = np.zeros((3, 3))
    for pattern, weight in enumerate(weights):
        key = np.random.SeedSequence([7, 1, 16 + pattern]).generate_state(2, np.uint64)
        for i, (column, row) in enumerate(noise.pixels.tolist()):
            for k in range(3):
                field = sum(
                    taps[m]
                    * taps[n]
                    * box_muller(column + n - reach, row + m - reach, int(noise.first[i]) + k, key)
                    for m in range(len(taps))
                    for n in range(len(taps))
                )
                if contrast > 0.25:
                    expected[i, k] += weight / 2 * abs(field) ** 2
                else:
                    expected[i, k] = (1 - contrast**2 / 9 + contrast / 3 * field.real) ** 3
    assert speckle.factors(noise, contrast, size) == pytest.approx(expected, rel=1e-9)

"""Random numbers of samples: uniform, independent, and the same whatever else is measured."""

import numpy as np
import pytest
from scipy import stats

from scanner_sim.optics.noise import SampleNoise, mixed

LEAST = 1e-3
"""Smallest accepted p-value."""


def noise_of(pixels, first=50, width=9, seed=3, view=1):
    return SampleNoise(seed, view, pixels, np.full(len(pixels), first), width)


def grid(side=150):
    column, row = np.meshgrid(np.arange(side), np.arange(side))
    return np.stack([column.ravel(), row.ravel()], axis=1).astype(np.int32)


def test_numbers_are_uniform_and_normal():
    noise = noise_of(grid())
    assert stats.kstest(noise.uniform(0).ravel(), "uniform").pvalue > LEAST
    assert stats.kstest(noise.normal(0).ravel(), "norm").pvalue > LEAST


def test_neighbours_stripes_streams_views_and_seeds_are_uncorrelated():
    pixels = grid()
    base = noise_of(pixels).normal(0)
    others = [
        noise_of(pixels).normal(1),
        noise_of(pixels, view=2).normal(0),
        noise_of(pixels, seed=4).normal(0),
        np.roll(base, 1, axis=0),
        np.roll(base, 150, axis=0),
        np.roll(base, 1, axis=1),
    ]
    for other in others:
        assert stats.pearsonr(base.ravel(), other.ravel()).pvalue > LEAST


def test_a_sample_keeps_its_number_whatever_else_is_measured():
    pixels = grid(20)
    whole = noise_of(pixels).uniform(2)
    some = np.array([7, 380, 3])
    moved = SampleNoise(3, 1, pixels[some], np.array([50, 52, 47]), 9).uniform(2)
    assert (moved[0] == whole[7]).all()
    assert (moved[1][:7] == whole[380][2:]).all()
    assert (moved[2][3:] == whole[3][:6]).all()


def test_hash_is_that_of_splitmix64():
    """The first numbers of the generator from the seed 1234567, as published with it."""
    with np.errstate(over="ignore"):
        state = np.uint64(1234567) + np.uint64(0x9E3779B97F4A7C15) * np.arange(1, 6, dtype=np.uint64)
        found = mixed(state)
    assert found.tolist() == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
        4593380528125082431,
        16408922859458223821,
    ]


def written_out(noise, stream):
    """The hash of each sample in whole numbers, one after the other."""
    most = 2**64 - 1

    def scramble(z):
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 & most
        z = (z ^ (z >> 27)) * 0x94D049BB133111EB & most
        return z ^ (z >> 31)

    first_key, second_key = (
        int(k) for k in np.random.SeedSequence([noise.seed, noise.view, stream]).generate_state(2, np.uint64)
    )
    rows = []
    for (column, row), first in zip(noise.pixels.tolist(), noise.first.tolist(), strict=True):
        pixel = scramble(((row << 32 | column) + first_key) & most)
        stripes = [(first + k) % 2**64 * 0x9E3779B97F4A7C15 for k in range(noise.width)]
        bits = [scramble((scramble((pixel + each) & most) + second_key) & most) for each in stripes]
        rows.append([((each >> 12) + 0.5) / 2**52 for each in bits])
    return np.array(rows)


def test_numbers_are_the_hash_of_pixel_stripe_and_seed():
    noise = SampleNoise(5, 2, np.array([[3, 70], [400, 1]], np.int32), np.array([-2, 700]), 4)
    for stream in (0, 3):
        assert np.array_equal(noise.uniform(stream), written_out(noise, stream))
        assert stats.norm.cdf(noise.normal(stream)) == pytest.approx(noise.uniform(stream), abs=1e-12)

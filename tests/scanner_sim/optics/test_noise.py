"""Random numbers of samples: uniform, independent, and the same whatever else is measured."""

import numpy as np
from scipy import stats

from scanner_sim.optics.noise import SampleNoise

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

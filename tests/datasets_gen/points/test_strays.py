"""Points far from everything else are told from pieces of a scan."""

import numpy as np
import pytest

from datasets_gen.points.strays import stray_points, words
from tests.medial import clouds


@pytest.mark.parametrize("distance", [10, 1e4, 1e6])
@pytest.mark.parametrize("count", [1, 3, 20])
@pytest.mark.parametrize("spread", [1e-3, 1.0])
def test_strays_together_or_apart(distance, count, spread):
    points, _ = clouds.body(600, holes=3)
    random = np.random.default_rng(count)
    away = np.array([1.0, 0.5, -0.3]) + spread * random.normal(size=(count, 3))
    where = random.permutation(600 + count)
    cloud = np.concatenate([points, distance * away])[where]
    assert np.array_equal(stray_points(cloud), where >= 600)


def test_pieces_of_a_scan_are_not_stray():
    points, _ = clouds.body(600)
    assert not stray_points(points).any()
    cut = points[(points[:, 0] < 0.4) | (points[:, 0] > 0.85)]  # a hand far from its arm
    assert not stray_points(cut).any()


def test_two_bodies_are_not_stray():
    points, _ = clouds.body(300)
    assert not stray_points(np.concatenate([points, points + np.array([100, 0, 0])])).any()


@pytest.mark.parametrize("n", [1, 2, 8])
def test_few_points_are_never_stray(n):
    assert not stray_points(np.arange(3.0 * n).reshape(n, 3) ** 9).any()


def test_words():
    assert words(np.arange(9) < 1) == "1 point of 9 lies far from all others"
    assert words(np.arange(9) < 2) == "2 points of 9 lie far from all others"

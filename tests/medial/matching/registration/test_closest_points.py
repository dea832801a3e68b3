"""Nearest places in six coordinates against scipy's tree."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from medial.matching.registration.closest_points import (
    FEW,
    LEAF,
    PlaceTree,
    mean_distance,
    nearest_of_few,
    nearest_places,
)


@pytest.mark.uncompiled
@pytest.mark.parametrize(("places", "goals"), [(1, 5), (300, 200), (7, 1)])
def test_nearest_of_few_is_that_of_a_tree(places, goals):
    random = np.random.default_rng(places)
    x, y = random.standard_normal((places, 6)), random.standard_normal((goals, 6))
    assert np.array_equal(nearest_of_few(x, y), cKDTree(x).query(y)[1])


@pytest.mark.uncompiled
def test_mean_distance():
    points, goals = np.random.default_rng(0).standard_normal((2, 40, 3))
    assert mean_distance(points, goals) == pytest.approx(np.linalg.norm(points - goals, axis=1).mean())
    assert mean_distance(points, points + np.array([3.0, 0, 4])) == pytest.approx(5)


@pytest.mark.uncompiled
def test_of_equally_near_places_the_first_is_taken():
    place = np.ones((1, 6))
    assert np.array_equal(nearest_of_few(np.tile(place, (4, 1)), 2 * place), [0])


@given(
    places=st.integers(1, 40 * LEAF),
    goals=st.integers(0, 50),
    flat=st.integers(0, 5),
    far=st.sampled_from([0.0, 1.0, 1e3]),
    seed=st.integers(0, 99),
)
def test_tree_finds_what_scipy_finds(places, goals, flat, far, seed):
    random = np.random.default_rng(seed)
    x, y = random.standard_normal((places, 6)), random.standard_normal((goals, 6)) + far
    x[:, :flat] = 0  # places in a plane
    assert np.array_equal(PlaceTree(x).nearest(y), cKDTree(x).query(y)[1])


@pytest.mark.parametrize("count", [LEAF // 2, 20 * LEAF])
def test_tree_of_places_that_coincide(count):
    random = np.random.default_rng(count)
    x = np.round(random.standard_normal((count, 6)))  # many more than once, and ties
    y = np.round(2 * random.standard_normal((100, 6))) / 2
    found = PlaceTree(x).nearest(y)
    assert np.allclose(np.linalg.norm(x[found] - y, axis=1), cKDTree(x).query(y)[0], rtol=1e-12)
    alike = PlaceTree(np.ones((count, 6))).nearest(y)
    assert ((alike >= 0) & (alike < count)).all()


@pytest.mark.uncompiled
def test_tree_uncompiled():
    random = np.random.default_rng(1)
    x, y = random.standard_normal((5 * LEAF, 6)), random.standard_normal((30, 6))
    assert np.array_equal(PlaceTree(x).nearest(y), cKDTree(x).query(y)[1])


@pytest.mark.parametrize("count", [FEW, FEW + 1])
def test_few_and_many_places_find_the_same(count):
    random = np.random.default_rng(count)
    x, y = random.standard_normal((count, 6)), random.standard_normal((40, 6))
    assert np.array_equal(nearest_places(x, y), cKDTree(x).query(y)[1])


def test_goals_that_are_not_finite_are_refused():
    with pytest.raises(FloatingPointError, match="left the finite numbers"):
        PlaceTree(np.ones((3, 6))).nearest(np.full((1, 6), np.nan))

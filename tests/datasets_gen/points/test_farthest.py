"""Farthest-point orders against slow ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from datasets_gen.points.farthest import (
    farthest_from_mean,
    farthest_in_embedding,
    farthest_in_metric,
    farthest_points,
)


@pytest.fixture(scope="module")
def points():
    return np.random.default_rng(0).standard_normal((400, 3)) * [1.0, 0.3, 0.2]


def slow_order(x, count, start, chosen):
    """Squared gaps to all points picked before; of equal ones the first, and none twice."""
    order = [start]
    while len(order) < min(count, len(x)):
        gap = ((x[:, None] - x[[*chosen, *order]]) ** 2).sum(axis=2).min(axis=1)
        gap[order] = -np.inf
        order.append(int(gap.argmax()))
    return order


@pytest.mark.uncompiled
@settings(max_examples=60, deadline=None, derandomize=True, database=None)
@given(st.data())
def test_the_order_in_an_embedding_matches_a_slow_one(data):
    """On a small grid, so that points coincide and gaps are equal."""
    n, d = data.draw(st.integers(1, 60)), data.draw(st.sampled_from([1, 2, 3, 9]))
    x = np.random.default_rng(data.draw(st.integers(0, 99))).integers(0, 6, (n, d)).astype(float)
    chosen = data.draw(st.lists(st.integers(0, n - 1), max_size=4))
    start, count = data.draw(st.integers(0, n - 1)), data.draw(st.integers(1, n + 3))
    found = farthest_in_embedding(x, count, start, chosen=np.array(chosen, dtype=np.int64))
    assert found.tolist() == slow_order(x, count, start, chosen)


def test_the_order_of_many_dimensions_matches_a_slow_one():
    x = np.random.default_rng(0).normal(size=(300, 40))
    assert farthest_in_embedding(x, 90, 7).tolist() == slow_order(x, 90, 7, [])


@pytest.mark.uncompiled
def test_the_order_of_identical_points_are_distinct():
    assert sorted(farthest_in_embedding(np.zeros((9, 3)), 20, 4)) == list(range(9))


def test_the_order_from_the_mean_is_greedy(points):
    order = farthest_from_mean(points, 40)
    gap = np.linalg.norm(points - points[order[0]], axis=1)
    for point in order[1:]:
        assert point == gap.argmax()
        gap = np.minimum(gap, np.linalg.norm(points - points[point], axis=1))
    assert sorted(farthest_from_mean(points[:30], 100)) == list(range(30))


def test_the_order_from_the_mean_starts_farthest_from_the_mean(points):
    expected = np.linalg.norm(points - points.mean(axis=0), axis=1).argmax()
    assert farthest_from_mean(points, 40)[0] == expected


def test_the_order_from_the_mean_does_not_depend_on_the_order_of_points(points):
    shuffle = np.random.default_rng(0).permutation(len(points))
    assert np.array_equal(shuffle[farthest_from_mean(points[shuffle], 40)], farthest_from_mean(points, 40))


def test_scans_are_sampled_greedily(points):
    """fpsample rounds to single precision: the same gaps, in the same order."""
    order = farthest_points(points, 60, 3)
    assert len(np.unique(order)) == 60
    assert order.tolist() == slow_order(points, 60, int(order[0]), [])


def test_of_a_single_point_there_is_one_sample():
    assert farthest_points(np.zeros((1, 3)), 1, 0).tolist() == [0]


@pytest.mark.uncompiled
def test_the_order_in_a_metric_is_that_of_its_distances(points):
    table = np.linalg.norm(points[:, None] - points, axis=2)
    order, distances = farthest_in_metric(table.__getitem__, 30, 7)
    assert order.tolist() == slow_order(points, 30, 7, [])
    assert np.array_equal(distances, table[order])


@pytest.mark.uncompiled
def test_a_metric_of_few_points_gives_each_once():
    table = np.abs(np.subtract.outer(np.arange(5.0), np.arange(5.0)))
    order, distances = farthest_in_metric(table.__getitem__, 9, 1)
    assert sorted(order) == list(range(5))
    assert distances.shape == (5, 5)


def test_points_without_a_path_are_farthest():
    table = np.array([[0, 1, np.inf], [1, 0, np.inf], [np.inf, np.inf, 0]])
    assert farthest_in_metric(table.__getitem__, 2, 0)[0].tolist() == [0, 2]


@pytest.mark.parametrize(("factor", "offset"), [(1, 5e6), (1, -1e9), (1e-30, 0), (1e25, 0), (1e-3, 1e3)])
def test_scans_are_sampled_alike_wherever_they_lie_and_in_any_unit(factor, offset):
    """5,000 random points: single precision far from the origin knows a few places only."""
    points = 2 * np.random.default_rng(0).random((5000, 3))
    order = farthest_points(points * factor + offset, 500, 3)
    assert len(np.unique(order)) == 500
    gaps = [cKDTree(points[each]).query(points)[0].max() for each in (order, farthest_points(points, 500, 3))]
    assert gaps[0] == pytest.approx(gaps[1], rel=0.02)


def test_near_the_origin_points_are_taken_as_they_are(points):
    import fpsample

    order = fpsample.bucket_fps_kdline_sampling(points + 20, 60, h=7, start_idx=3)
    assert farthest_points(points + 20, 60, 3).tolist() == order.tolist()


def test_samples_of_coinciding_points_are_distinct(points):
    assert sorted(farthest_points(np.zeros((9, 3)), 9, 4)) == list(range(9))
    twice = np.repeat(points[:20], 2, axis=0)
    order = farthest_points(twice, 30, 5)
    assert len(np.unique(order)) == 30
    assert len(np.unique(order[:20] // 2)) == 20  # every place before any twice

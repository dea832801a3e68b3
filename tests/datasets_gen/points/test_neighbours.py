"""Graphs of nearest neighbours, and the bridges between their parts."""

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree
from scipy.spatial import cKDTree

from datasets_gen.points.neighbours import ROWS_PER_TASK, join_parts, neighbour_pairs, query_tree


def islands(count=5, each=40, seed=0):
    random = np.random.default_rng(seed)
    centres = 20 * random.standard_normal((count, 3))
    return (centres[:, None] + random.standard_normal((count, each, 3))).reshape(-1, 3)


def graph(pairs, n):
    return csr_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))


@pytest.mark.parametrize("k", [1, 4])
@pytest.mark.parametrize("count", [0, 1, 2 * ROWS_PER_TASK + 5])
def test_a_tree_answers_as_scipy_does(count, k):
    random = np.random.default_rng(0)
    tree, points = cKDTree(random.random((300, 3))), 1.2 * random.random((count, 3))
    for within in (np.inf, 0.05):
        found, expected = (
            query_tree(tree, points, k, within),
            tree.query(points, k, distance_upper_bound=within),
        )
        assert np.array_equal(found[0], expected[0])
        assert np.array_equal(found[1], expected[1])


def test_pairs_are_the_nearest_neighbours():
    points = np.random.default_rng(0).standard_normal((50, 4))
    gap = np.linalg.norm(points[:, None] - points, axis=2)
    np.fill_diagonal(gap, np.inf)
    expected = {tuple(sorted((i, int(j)))) for i in range(50) for j in np.argsort(gap[i])[:6]}
    assert neighbour_pairs(cKDTree(points), 6).tolist() == sorted(map(list, expected))


def test_of_few_points_all_are_paired():
    assert neighbour_pairs(cKDTree(np.eye(3)), 9).tolist() == [[0, 1], [0, 2], [1, 2]]
    assert neighbour_pairs(cKDTree(np.zeros((1, 3))), 9).shape == (0, 2)


def test_one_bridge_per_gap_is_the_minimum_spanning_tree_of_the_parts():
    points = islands()
    pairs = neighbour_pairs(cKDTree(points), 6)
    parts, label = connected_components(graph(pairs, len(points)), directed=False)
    assert parts == 5
    gap = np.linalg.norm(points[:, None] - points, axis=2)
    between = np.array([[gap[np.ix_(label == a, label == b)].min() for b in range(5)] for a in range(5)])
    joined = join_parts(pairs, points)
    added = sorted(set(map(tuple, joined)) - set(map(tuple, pairs)))
    assert connected_components(graph(joined, len(points)), directed=False)[0] == 1
    assert sum(gap[i, j] for i, j in added) == pytest.approx(minimum_spanning_tree(between).sum())


def test_several_bridges_start_at_several_points():
    points = islands(count=2)
    pairs = neighbour_pairs(cKDTree(points), 6)
    added = set(map(tuple, join_parts(pairs, points, bridges=2))) - set(map(tuple, pairs))
    assert len(added) == 2


def test_with_a_hub_every_part_is_joined_to_the_largest():
    points = np.concatenate([islands(count=1, each=60), *(islands(3, 30, seed=1).reshape(3, 30, 3))])
    pairs = neighbour_pairs(cKDTree(points), 6)
    _, label = connected_components(graph(pairs, len(points)), directed=False)
    hub = np.bincount(label).argmax()
    added = set(map(tuple, join_parts(pairs, points, hub=True))) - set(map(tuple, pairs))
    assert len(added) == 3
    assert all(hub in (label[i], label[j]) for i, j in added)
    for part in set(label) - {hub}:
        gap = np.linalg.norm(points[label == part][:, None] - points[label == hub], axis=2).min()
        bridge = [np.linalg.norm(points[i] - points[j]) for i, j in added if part in (label[i], label[j])]
        assert bridge == pytest.approx([gap])


def test_a_connected_graph_stays_as_it_is():
    points = np.random.default_rng(0).standard_normal((60, 3))
    pairs = neighbour_pairs(cKDTree(points), 10)
    assert np.array_equal(join_parts(pairs, points), pairs)


def test_no_point_is_paired_with_itself():
    assert join_parts(np.array([[0, 0], [1, 0], [0, 1]]), np.eye(3)[:2]).tolist() == [[0, 1]]

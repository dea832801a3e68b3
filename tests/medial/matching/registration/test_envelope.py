"""Envelope storage and its Cholesky factor, against dense matrices."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from medial.matching.registration.deformation_graph import NodeGraph
from medial.matching.registration.energy_terms import add_points
from medial.matching.registration.envelope import Envelope, cholesky_solve, solve
from tests.medial.posed import rest_pose

LOWEST = {
    "one node": [0],
    "full": [0, 0, 0, 0],
    "diagonal": [0, 1, 2, 3, 4],
    "chain": [0, 0, 1, 2, 3, 4],
    "wider again": [0, 0, 2, 0, 3, 1, 1],
}


def random_system(lowest, seed=0):
    """A positive definite system whose lower triangle fills the envelope: envelope, values, matrix, right."""
    envelope = Envelope(np.array(lowest))
    values = np.random.default_rng(seed).standard_normal(len(envelope.zeros()))
    values[envelope.diagonal] = 6 * len(lowest) * 3.0
    lower = envelope.dense(values)
    return envelope, values, lower + np.tril(lower, -1).T, np.random.default_rng(seed + 1).random(len(lower))


def test_numbers_lie_where_they_are_said_to():
    envelope = Envelope(np.array([0, 0, 1, 3, 4]))
    values = np.arange(len(envelope.zeros()), dtype=float)
    assert len(values) == 6 * 12 * (2 + 3 + 2)  # strips of nodes 0 and 1, 2 and 3, 4 alone
    matrix = envelope.dense(values)
    for i, low in enumerate([0, 0, 1, 1, 4]):
        for j in range(5):
            block = matrix[6 * i : 6 * i + 6, 6 * j : 6 * j + 6]
            if low <= j <= i:
                at = envelope.origin[i] + 72 * j + 12 * np.arange(6) + np.arange(6)[:, None]
                assert np.array_equal(block, values[at] if j < i else np.tril(values[at]))
            else:
                assert not block.any()
    assert np.array_equal(values[envelope.diagonal], matrix.diagonal())


@pytest.mark.uncompiled
@pytest.mark.parametrize("lowest", LOWEST.values(), ids=LOWEST)
def test_the_solution_is_that_of_the_dense_matrix(lowest):
    envelope, values, matrix, right = random_system(lowest)
    found = cholesky_solve(values, right, envelope.first, envelope.origin)
    assert np.allclose(found, np.linalg.solve(matrix, right), rtol=1e-9)
    assert np.allclose(envelope.dense(values), np.linalg.cholesky(matrix), rtol=1e-9)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(0, 7), min_size=2, max_size=12), st.integers(0, 100))
def test_any_envelope(widths, seed):
    lowest = [max(0, i - width) for i, width in enumerate(widths)]
    envelope, values, matrix, right = random_system(lowest, seed)
    found = cholesky_solve(values, right, envelope.first, envelope.origin)
    assert np.allclose(matrix @ found, right, rtol=1e-9)


def test_what_lies_above_the_diagonal_is_not_read():
    envelope, values, _, right = random_system(LOWEST["wider again"])
    other, mine = np.full(len(values), 7.0), envelope.dense(np.arange(1.0, len(values) + 1)).astype(int)
    read = mine[mine > 0] - 1
    other[read] = values[read]
    assert not np.array_equal(other, values)
    both = [cholesky_solve(v, right, envelope.first, envelope.origin) for v in (values, other)]
    assert np.array_equal(*both)


def test_solutions_are_slightly_damped():
    envelope, values, matrix, right = random_system(LOWEST["chain"])
    damped = matrix + np.eye(len(matrix)) * (1e-6 * matrix.trace() / len(matrix) + 1e-12)
    assert np.allclose(solve(values, right, envelope), np.linalg.solve(damped, right), rtol=1e-12)


def test_an_envelope_holds_all_of_a_system():
    """What points and edges of a long body add is the same in an envelope and in a full triangle."""
    points = np.random.default_rng(0).standard_normal((800, 3)) * [8, 0.1, 0.1]
    graph, hang = NodeGraph.over(points.astype(np.float32), points, np.arange(800), 60)
    pose, metric = rest_pose(graph), np.tile(np.eye(3), (800, 1, 1))
    force = np.random.default_rng(1).standard_normal((800, 3))
    found = []
    for envelope in (graph.envelope, Envelope(np.zeros(60, np.int64))):
        values, right = envelope.zeros(), np.zeros(360)
        here = points, hang.nodes, hang.weights, graph.rest, pose.rotations
        add_points(values, envelope.origin, right, *here, metric, force)
        with_edges = NodeGraph(*(vars(graph) | {"envelope": envelope}).values())
        with_edges.add_edges(values, right, pose, 2.0)
        found.append((len(values), envelope.dense(values), right))
    assert found[0][0] < found[1][0] / 2
    assert np.array_equal(found[0][1], found[1][1])
    assert np.array_equal(found[0][2], found[1][2])

"""Distances from a set of surface points against searches one after the other."""

import heapq

import numpy as np
import pytest
from scipy.sparse import csr_array

from evaluation.metrics.nearest_place import in_sight, onward, straight_lines
from evaluation.metrics.unfolding import ENTRY_DEPTH, REACHED, enter, face_adjacency
from tests.evaluation.meshes import plane, random_points, sphere

pytestmark = pytest.mark.uncompiled


def test_straight_lines_are_those_of_each_point():
    shape = sphere(1)
    faces = shape.faces.astype(np.int64)
    mesh = (shape.vertices, faces, *face_adjacency(faces))
    face_ids, weights = random_points(shape, 5)
    start, vertex, length = straight_lines(*mesh, face_ids, weights)
    assert start[0] == 0
    assert start[-1] == len(vertex) == len(length)
    for i in range(5):
        ids, lengths = np.empty(REACHED, np.int64), np.empty(REACHED)
        used, _ = enter(*mesh, face_ids[i], weights[i], -1, np.zeros(3), ids, lengths)
        assert vertex[start[i] : start[i + 1]].tolist() == ids[:used].tolist()
        assert length[start[i] : start[i + 1]].tolist() == lengths[:used].tolist()


def shortest(graph, least):
    """Dijkstra's search from a place outside that each vertex reaches at once, or not."""
    found, queue = np.full(len(least), np.inf), [(way, v) for v, way in enumerate(least) if way < np.inf]
    heapq.heapify(queue)
    while queue:
        way, v = heapq.heappop(queue)
        if way < found[v]:
            found[v] = way
            for w in np.flatnonzero(graph[v]):
                heapq.heappush(queue, (way + graph[v, w], int(w)))
    return found


def test_ways_onward_lead_through_the_graph_and_out_of_it():
    random = np.random.default_rng(0)
    graph = np.triu(random.uniform(0.1, 1, (12, 12)) * (random.uniform(size=(12, 12)) < 0.25), 1)
    graph += graph.T
    graph[11], graph[:, 11] = 0, 0  # out of reach
    least = np.full(12, np.inf)
    least[[2, 5, 7]] = [0.4, 0.1, 2.5]
    found = onward(csr_array(graph), least)
    assert found == pytest.approx(shortest(graph, least))
    assert found[11] == np.inf
    assert found[7] < 2.5


def faces_away(neighbour, face):
    """Edges between a face and every other one."""
    away, wave, steps = np.full(len(neighbour), 10**6), {face}, 0
    while wave:
        for each in wave:
            away[each] = steps
        steps += 1
        wave = {int(g) for f in wave for g in neighbour[f] if g >= 0 and away[g] == 10**6}
    return away


def test_points_in_sight_are_few_faces_apart():
    shape = plane(9)
    neighbour = face_adjacency(shape.faces)[0]
    face_ids, other = random_points(shape, 12, 1)[0], random_points(shape, 15, 2)[0]
    found = set(zip(*(each.tolist() for each in in_sight(neighbour, face_ids, other)), strict=True))
    expected = {
        (i, j)
        for i, face in enumerate(face_ids)
        for j, away in enumerate(faces_away(neighbour, face)[other])
        if away <= ENTRY_DEPTH
    }
    assert found == expected
    assert 0 < len(expected) < 12 * 15

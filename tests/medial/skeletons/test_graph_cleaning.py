"""Graphs drawn by hand."""

import networkx as nx
import numpy as np
import pytest

from medial.skeletons.graph_cleaning import bridged, collapsed, pruned, without_specks, zipped
from medial.skeletons.joint_places import settled_joints


def graph(places, edges, radius=0.3, points=1):
    found = nx.Graph()
    for k, place in enumerate(places):
        members = np.arange(points) + points * k
        found.add_node(k, place=np.asarray(place, float), radius=radius, members=members)
    found.add_edges_from(edges)
    return found


def members(found):
    return sorted(np.concatenate([found.nodes[k]["members"] for k in found.nodes]).tolist())


def test_triangles_and_small_loops_collapse():
    found = graph([[0, 0, 0], [0.1, 0, 0], [0, 1, 0], [1, 0, 0]], [(0, 1), (1, 2), (0, 2), (1, 3)])
    collapsed(found)
    assert nx.is_tree(found)
    assert members(found) == [0, 1, 2, 3]
    assert found.nodes[0]["place"] == pytest.approx([0.05, 0, 0])


@pytest.mark.parametrize(("size", "left"), [(0.2, 0), (1.0, 1)], ids=["of a joint", "a handle"])
def test_loops_shorter_than_a_handle_collapse(size, left):
    """A handle of a body of radius r is at least 2 pi r long."""
    turn = 2 * np.pi * np.arange(8) / 8
    places = size * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    found = graph(places, [(k, (k + 1) % 8) for k in range(8)])
    collapsed(found)
    assert found.number_of_edges() - found.number_of_nodes() + 1 == left


def test_strands_are_zipped():
    places = [[0, 0, 0], [1, 0.05, 0], [2, -0.05, 0], [3, 0, 0]]
    found = graph(places, [(0, 1), (0, 2), (0, 3)])
    zipped(found)
    assert sorted(map(sorted, found.edges)) == [[0, 1], [1, 2], [2, 3]]


def test_limbs_side_by_side_are_not_zipped():
    places = [[0, 0, 0], [0.4, -1, 0], [-0.4, -1.2, 0]]
    found = graph(places, [(0, 1), (0, 2)])
    zipped(found)
    assert sorted(map(sorted, found.edges)) == [[0, 1], [0, 2]]


@pytest.mark.parametrize(
    ("places", "joined"),
    [
        ([[0, 0, 0], [0, 1, 0], [0, 2, 0], [0, 3, 0]], True),
        ([[0, 0, 0], [0, 1, 0], [0, 3, 0], [0, 4, 0]], False),
        ([[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]], False),
    ],
    ids=["goes on", "too far", "beside"],
)
def test_bridges(places, joined):
    found = graph(places, [(0, 1), (2, 3)])
    bridged(found)
    assert nx.is_connected(found) == joined


def test_stubs_are_cut_and_branches_stay():
    chain = [[x, 0, 0] for x in range(5)]
    found = graph([*chain, [2, 0.3, 0], [1, 1.5, 0]], [(0, 1), (1, 2), (2, 3), (3, 4), (2, 5), (1, 6)])
    pruned(found)
    assert sorted(found.nodes) == [0, 1, 2, 3, 4, 6]
    assert members(found) == list(range(7))
    assert sorted(found.nodes[2]["members"]) == [2, 5]


def test_specks_go_and_their_points_stay():
    found = graph([[0, 0, 0], [0, 1, 0], [9, 0, 0]], [(0, 1)], points=100)
    found.nodes[2]["members"] = np.array([200])
    without_specks(found)
    assert sorted(found.nodes) == [0, 1]
    assert members(found) == list(range(201))
    alone = graph([[0, 0, 0]], [])
    without_specks(alone)
    assert len(alone) == 1


def test_joints_lie_where_lines_meet():
    """Three lines through the origin; the joint and the nodes in the joint are off."""
    ways = np.array([[0, -1.0, 0], [0.8, 0.6, 0], [-0.8, 0.6, 0]])
    steps = (0.2, 0.6, 0.8, 1.0)
    places = [[0.1, 0.2, 0.1], *(step * way + 0.1 * (step < 0.3) for way in ways for step in steps)]
    edges = [(k - 1 if (k - 1) % 4 else 0, k) for k in range(1, 13)]
    found = graph(places, edges)
    settled_joints(found)
    assert found.nodes[0]["place"] == pytest.approx(np.zeros(3), abs=1e-12)
    for first, way in zip((1, 5, 9), ways, strict=True):
        assert np.cross(found.nodes[first]["place"], way) == pytest.approx(np.zeros(3), abs=1e-12)
        assert found.nodes[first + 3]["place"] == pytest.approx(way)

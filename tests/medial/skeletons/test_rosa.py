"""Skeletons of shapes whose centre lines are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from datasets_gen.records import InputError
from medial.skeletons import RosaSettings, medial_skeleton, rosa_skeleton
from tests.medial.clouds import planes, rotation, sphere
from tests.medial.skeletons import tubes

SHAPES = {"straight": tubes.straight, "bent": tubes.bent, "forked": tubes.forked, "ring": tubes.ring}
TOPOLOGY = {"straight": (2, 0, 0), "bent": (2, 0, 0), "forked": (3, 1, 0), "ring": (0, 0, 1)}
SIDES = {"straight": [1, 0, 0], "bent": [0, 0, 1], "forked": [0, 0, 1], "ring": [0, 0, 1]}


@pytest.fixture(scope="module")
def clouds():
    return {name: make() for name, make in SHAPES.items()}


@pytest.fixture(scope="module")
def found(clouds):
    return {name: rosa_skeleton(tube.points, tube.normals) for name, tube in clouds.items()}


def topology(skeleton):
    return (int((skeleton.kinds == "tip").sum()), int((skeleton.kinds == "joint").sum()), skeleton.loops)


def off_line(skeleton, line):
    """Mean distance of the skeleton from the centre line, in radii."""
    return cKDTree(line).query(skeleton.sampled(0.02)[0])[0].mean() / tubes.RADIUS


def off_skeleton(skeleton, line):
    """Largest distance of the centre line from the skeleton, in radii."""
    return cKDTree(skeleton.sampled(0.02)[0]).query(line)[0].max() / tubes.RADIUS


@pytest.mark.parametrize("name", SHAPES)
def test_complete(clouds, found, name):
    tube, found = clouds[name], found[name]
    assert topology(found) == TOPOLOGY[name]
    assert np.unique(found.components).size == 1
    assert off_line(found, tube.line) < 0.05
    assert off_skeleton(found, tube.line) < 1.0  # the ends as well
    inner = found.kinds == "inner"
    assert found.radii[inner] == pytest.approx(tubes.RADIUS, rel=0.2)
    assert found.reason == ""


@pytest.mark.parametrize("name", SHAPES)
def test_half_of_the_surface_gone_on_one_side(clouds, name):
    tube = clouds[name].facing(SIDES[name])
    assert 0.4 < len(tube.points) / len(clouds[name].points) < 0.6
    found = rosa_skeleton(tube.points, tube.normals)
    assert topology(found) == TOPOLOGY[name]
    assert off_line(found, tube.line) < 0.10
    assert off_skeleton(found, tube.line) < 1.0


@pytest.mark.parametrize("name", SHAPES)
def test_points_belong_to_the_nodes_beside_them(clouds, found, name):
    tube, found = clouds[name], found[name]
    assert found.node_of_point.shape == (len(tube.points),)
    assert found.node_of_point.min() >= 0
    away = np.linalg.norm(tube.points - found.nodes[found.node_of_point], axis=1) / tubes.RADIUS
    assert np.median(away) < 1.3
    assert np.unique(found.node_of_point).size == len(found)


@pytest.mark.parametrize("name", SHAPES)
def test_medial_centres_give_the_same_curves(clouds, name):
    tube = clouds[name]
    found = medial_skeleton(tube.points, tube.normals)
    assert topology(found) == TOPOLOGY[name]
    assert off_line(found, tube.line) < 0.10


def test_a_ball_has_one_node_and_a_reason():
    found = rosa_skeleton(*sphere(600))
    assert len(found) == 1
    assert len(found.edges) == 0
    assert found.nodes[0] == pytest.approx(np.zeros(3), abs=0.05)
    assert "a ball has no axis" in found.reason
    assert (found.node_of_point == 0).all()


@pytest.mark.parametrize("extract", [rosa_skeleton, medial_skeleton])
def test_a_sheet_has_no_node_and_a_reason(extract):
    found = extract(*planes(700, gap=0.03))
    assert len(found) == 0
    assert "flat" in found.reason
    assert (found.node_of_point == -1).all()


def test_two_bodies_give_a_forest(clouds):
    tube = clouds["straight"]
    points = np.concatenate([tube.points, np.add(tube.points, [2.5, 0, 0])])
    found = rosa_skeleton(points, np.tile(tube.normals, (2, 1)))
    assert np.unique(found.components).size == 2
    assert topology(found) == (4, 0, 0)
    owner = found.components[found.node_of_point]
    assert (owner[: len(tube.points)] == owner[0]).all()
    assert (owner[len(tube.points) :] == owner[-1]).all()
    assert owner[0] != owner[-1]


def test_a_gap_in_one_tube_is_bridged(clouds):
    tube = clouds["straight"]
    kept = np.abs(tube.points[:, 1]) > 0.35  # more than two radii are missing
    found = rosa_skeleton(tube.points[kept], tube.normals[kept])
    assert topology(found) == (2, 0, 0)
    assert np.unique(found.components).size == 1


def test_missing_normals_are_estimated_and_said(clouds, caplog):
    tube = clouds["bent"]
    found = rosa_skeleton(tube.points)
    assert "normals are missing: estimated" in caplog.text
    assert topology(found) == (2, 0, 0)
    assert off_line(found, tube.line) < 0.1


def test_too_few_points():
    points, normals = sphere(10)
    with pytest.raises(InputError, match="10 distinct points are too few for a skeleton from 10 neighbours"):
        rosa_skeleton(points, normals)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"step": 0.0}, "step is 0.0; give a number above 0"),
        ({"neighbours": 2}, "neighbours is 2; give a whole number of at least 3"),
        ({"recentring": 1.5}, "recentring is 1.5; give a number from 0 to 1"),
        ({"thicknes": 1.0}, "did you mean 'thickness'"),
    ],
    ids=["step", "neighbours", "recentring", "unknown"],
)
def test_wrong_settings(wrong, said):
    with pytest.raises(InputError, match=said):
        RosaSettings(**wrong)


@given(st.integers(0, 1000), st.floats(1e-3, 1e3))
@settings(max_examples=3, deadline=None)
def test_turning_scaling_and_another_order_change_nothing(seed, scale):
    tube = tubes.bent(500)
    found = rosa_skeleton(tube.points, tube.normals)
    turn, shift = rotation(seed), scale * np.array([0.3, -2.0, 1.0])
    other = tube.moved(turn, scale, shift)
    order = np.random.default_rng(seed).permutation(len(tube.points))
    again = rosa_skeleton(other.points[order], other.normals[order])
    assert topology(again) == topology(found)
    there = scale * found.sampled(0.02)[0] @ turn.T + shift
    gaps = cKDTree(there).query(again.sampled(0.02 * scale)[0])[0]
    assert gaps.max() < 0.1 * scale * tubes.RADIUS + 0.02 * scale


def test_another_order_of_the_points_gives_the_very_same_skeleton():
    tube = tubes.forked(600)
    order = np.random.default_rng(1).permutation(len(tube.points))
    found = rosa_skeleton(tube.points, tube.normals)
    again = rosa_skeleton(tube.points[order], tube.normals[order])
    assert np.array_equal(found.nodes, again.nodes)
    assert np.array_equal(found.edges, again.edges)
    assert np.array_equal(found.node_of_point[order], again.node_of_point)

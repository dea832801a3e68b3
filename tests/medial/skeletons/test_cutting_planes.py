"""The compiled planes and centres against the equations as written."""

import numpy as np
import pytest

from medial.skeletons.cutting_planes import (
    first_directions,
    improved,
    plane_sums,
    smoothed,
    symmetry_axes,
    symmetry_directions,
)
from medial.skeletons.equations import (
    least_variance_direction,
    plane_points,
    symmetric_center,
    variance,
)
from medial.skeletons.surface_graph import SurfaceGraph
from tests.medial.clouds import cylinder, sphere
from tests.medial.skeletons import tubes

PROBES = range(0, 300, 29)


@pytest.fixture(scope="module")
def graph():
    tube = tubes.forked(300)
    random = np.random.default_rng(0)
    normals = tube.normals + 0.05 * random.normal(size=tube.normals.shape)
    return SurfaceGraph.of(tube.points, normals / np.linalg.norm(normals, axis=1, keepdims=True), 8)


@pytest.fixture(scope="module")
def directions(graph):
    found = np.random.default_rng(1).normal(size=(len(graph), 3))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def test_the_same_points_are_in_the_planes(graph, directions):
    sums = plane_sums(graph, graph.matrix(), directions, 0.2)
    for k in PROBES:
        members = plane_points(graph.points, graph.pairs, k, directions[k], 0.2)
        assert sums.count[k] == len(members)
        assert sums.normal[k] == pytest.approx(graph.normals[members].sum(axis=0), abs=1e-12)
        assert sums.place[k] == pytest.approx(
            (graph.points[members] - graph.points[k]).sum(axis=0), abs=1e-12
        )


def test_directions_are_those_of_least_variance(graph, directions):
    found, least = improved(graph, graph.matrix(), directions, 0.2)
    for k in PROBES:
        normals = graph.normals[plane_points(graph.points, graph.pairs, k, directions[k], 0.2)]
        expected = least_variance_direction(normals)
        assert abs(found[k] @ expected) == pytest.approx(1, abs=1e-6)
        assert least[k] == pytest.approx(variance(expected, normals), abs=1e-12)
        others = np.random.default_rng(k).normal(size=(50, 3))
        others /= np.linalg.norm(others, axis=1, keepdims=True)
        assert all(variance(other, normals) >= least[k] - 1e-12 for other in others)


def test_centres_solve_the_equations(graph):
    directions = symmetry_directions(graph, 0.15, 3)
    axes = symmetry_axes(graph, directions, 0.15)
    known = [k for k in range(len(graph)) if axes.tubular[k]][::23]
    assert len(known) > 5
    for k in known:
        members = plane_points(graph.points, graph.pairs, k, directions[k], 0.15)
        expected = symmetric_center(graph.points[members], graph.normals[members])
        assert axes.centers[k] == pytest.approx(expected, abs=1e-9)


def test_a_cylinder_by_hand():
    """Four points of a circle: the normals meet in its middle, whatever part of it they are on."""
    turn = np.radians([0, 20, 50, 80])
    normals = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    points = [1.0, 2.0, 3.0] + 0.5 * normals
    assert symmetric_center(points, normals) == pytest.approx([1, 2, 3])
    assert abs(least_variance_direction(normals)[2]) == pytest.approx(1)


def test_axes_of_a_cylinder_and_its_radius():
    points, normals = cylinder(800)
    graph = SurfaceGraph.of(points, normals, 10)
    axes = symmetry_axes(graph, symmetry_directions(graph, graph.spacing, 5), graph.spacing)
    assert axes.tubular.all()
    assert np.abs(axes.directions[:, 2]) == pytest.approx(1, abs=1e-6)
    assert axes.centers[:, :2] == pytest.approx(0, abs=1e-9)
    assert axes.radii == pytest.approx(0.3, abs=1e-6)


def test_first_directions_are_tangent():
    points, normals = sphere(400)
    graph = SurfaceGraph.of(points, normals, 8)
    assert np.einsum("nd,nd->n", first_directions(graph), normals) == pytest.approx(0, abs=1e-9)


def test_smoothing_does_not_mind_signs(graph, directions):
    near, signs = graph.matrix(), np.where(np.arange(len(graph)) % 2, 1.0, -1.0)[:, None]
    even = np.full(len(graph), 0.1)
    once, other = smoothed(near, directions, even), smoothed(near, signs * directions, even)
    assert np.abs(np.einsum("nd,nd->n", once, other)) == pytest.approx(1, abs=1e-6)


def test_parts_that_face_each_other_are_not_joined():
    """Two plates whose outer sides face each other across a gap, and one thin plate: its sides are joined."""
    x, y = (each.ravel() for each in np.meshgrid(np.arange(8.0), np.arange(8.0)))
    low, high = np.column_stack([x, y, 0 * x]), np.column_stack([x, y, 0 * x + 0.5])
    up = np.tile([0.0, 0, 1], (64, 1))
    apart = SurfaceGraph.of(np.concatenate([low, high]), np.concatenate([up, -up]), 8)
    assert not ((apart.pairs[:, 0] < 64) & (apart.pairs[:, 1] >= 64)).any()
    thin = SurfaceGraph.of(np.concatenate([low, high]), np.concatenate([-up, up]), 8)
    assert ((thin.pairs[:, 0] < 64) & (thin.pairs[:, 1] >= 64)).any()

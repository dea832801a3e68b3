"""Geodesics that are known on polyhedra, and on meshes so small that they can be followed without Numba."""

import numpy as np
import pytest
import trimesh

from evaluation.metrics.geodesic import SurfaceDistance
from tests.evaluation.meshes import as_shape, random_points

pytestmark = pytest.mark.uncompiled


def fine_box(subdivisions):
    """The surface of a unit cube about the origin."""
    mesh = trimesh.creation.box()
    for _ in range(subdivisions):
        mesh = mesh.subdivide()
    return as_shape(mesh.vertices, mesh.faces)


def at(shape, *places):
    """The vertices at some places."""
    gap = np.linalg.norm(shape.vertices[:, None] - np.array(places), axis=2)
    assert gap.min(axis=0).max() < 1e-12
    return gap.argmin(axis=0)


@pytest.mark.parametrize(
    ("one", "other", "length"),
    [
        ((0.5, 0, 0), (-0.5, 0, 0), 2.0),  # half a side, a side, half a side
        ((0.5, 0, 0), (0, 0.5, 0), 1.0),
        ((0.5, 0.5, 0.5), (-0.5, -0.5, -0.5), 5**0.5),  # two sides unfolded: a rectangle of 2 x 1
        ((0.5, 0.5, 0.5), (0.5, -0.5, -0.5), 2**0.5),
    ],
)
def test_ways_around_a_cube(one, other, length):
    cube = fine_box(1)
    ends = at(cube, one, other)
    found = SurfaceDistance(cube).from_vertices(ends[:1])[0, ends[1]]
    assert length - 1e-9 <= found <= 1.05 * length


def test_on_one_face_lines_are_straight():
    cube = fine_box(0)
    face = np.zeros(5, np.int64)
    weights = np.random.default_rng(0).dirichlet([1, 1, 1], size=(2, 5))
    straight = np.linalg.norm(cube.at(face, weights[0]) - cube.at(face, weights[1]), axis=1)
    assert SurfaceDistance(cube)(face, weights[0], face, weights[1]) == pytest.approx(straight)


def test_the_nearest_of_a_set_and_both_ways():
    ball = as_shape(trimesh.creation.icosphere(subdivisions=1).vertices,
                    trimesh.creation.icosphere(subdivisions=1).faces)  # fmt: skip
    distance, points, others = SurfaceDistance(ball), random_points(ball, 4, 1), random_points(ball, 5, 2)
    i, j = (each.ravel() for each in np.indices((4, 5)))
    there = distance(points[0][i], points[1][i], others[0][j], others[1][j]).reshape(4, 5)
    back = distance(others[0][j], others[1][j], points[0][i], points[1][i]).reshape(4, 5)
    assert there == pytest.approx(back, rel=1e-12)
    assert distance.to_nearest(*points, *others) == pytest.approx(there.min(axis=1), rel=1e-12)

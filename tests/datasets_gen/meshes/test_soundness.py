from dataclasses import replace

import numpy as np
import pytest

from datasets_gen.meshes.soundness import crossing_faces, edge_stretch
from tests.datasets_gen.sample_meshes import box, shape, shuffled, sphere


def pair(gap, fine=3, coarse=3):
    """Two unit spheres, their centres `gap` apart along x."""
    one, two = sphere(fine), sphere(coarse)
    vertices = np.concatenate([one.vertices, two.vertices + np.array([gap, 0, 0])])
    return shape(vertices, np.concatenate([one.faces, two.faces + len(one.vertices)]))


def test_spheres_cross_along_their_common_circle():
    found = pair(1.2)
    crossed = crossing_faces(found)
    middle = found.vertices[found.faces[crossed]].mean(axis=1)
    assert crossed.sum() > 50
    assert np.abs(middle[:, 0] - 0.6).max() < 0.15
    assert np.hypot(middle[:, 1], middle[:, 2]) == pytest.approx(0.8, abs=0.12)


def test_faces_of_very_different_sizes_are_compared():
    """A small sphere through one face of a large box: all its faces at the plane cross, and that one face."""
    ball, large = sphere(4, radius=0.05), box()
    center = np.array([0.5, 0.1, 0.2])
    vertices = np.concatenate([large.vertices, ball.vertices + center])
    found = shape(vertices, np.concatenate([large.faces, ball.faces + len(large.vertices)]))
    crossed = crossing_faces(found)
    assert crossed[: len(large.faces)].sum() == 1
    corners = found.vertices[found.faces[len(large.faces) :]][:, :, 0] - 0.5
    assert np.array_equal(crossed[len(large.faces) :], (corners.min(axis=1) < 0) & (corners.max(axis=1) > 0))


@pytest.mark.parametrize("gap", [2.05, 5.0])
def test_surfaces_apart_do_not_cross(gap):
    assert not crossing_faces(pair(gap, 3, 2)).any()
    assert not crossing_faces(sphere(4)).any()


def test_crossings_do_not_depend_on_the_order_of_faces():
    found = pair(1.2)
    assert crossing_faces(shuffled(found)).sum() == crossing_faces(found).sum()


def test_a_face_pushed_through_the_other_side_is_found():
    ball = sphere(3)
    vertices = ball.vertices.copy()
    top = vertices[:, 2].argmax()
    vertices[top] = (0.013, 0.007, -1.5)
    crossed = crossing_faces(replace(ball, vertices=vertices))
    assert crossed[(ball.faces == top).any(axis=1)].all()


def test_edges_of_a_stretched_sphere():
    ball = sphere(4)
    stretch = edge_stretch(replace(ball, vertices=ball.vertices * [1, 1, 1.5]), ball)
    assert stretch.shortest == pytest.approx(1, abs=2e-3)
    assert stretch.longest == pytest.approx(1.5, abs=2e-3)
    assert 1 <= stretch.low < 1.02 < 1.48 < stretch.high <= stretch.longest
    assert stretch.line == "edges x 1.00 to 1.50, 99 % of them 1.00 to 1.50"


def test_an_isometry_stretches_nothing():
    cube = box()
    turned = replace(cube, vertices=cube.vertices[:, [1, 2, 0]] + 3)
    assert edge_stretch(turned, cube) == pytest.approx((1, 1, 1, 1))

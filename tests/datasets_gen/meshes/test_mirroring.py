from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from datasets_gen import mirror_map
from datasets_gen.meshes.mirroring import best_reflection, connectivity_mirror, reflect
from tests.datasets_gen.sample_meshes import shape, shuffled, sphere

vectors = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array)


def irregular_sphere(count=2500):
    """A sphere whose connectivity has no symmetry."""
    points = np.random.default_rng(0).normal(size=(count, 3))
    hull = trimesh.PointCloud(points / np.linalg.norm(points, axis=1, keepdims=True)).convex_hull
    return shape(hull.vertices, hull.faces)


def blob(bump=0.0, mesh=None):
    """A smooth closed surface whose only mirror plane is x = 0; `bump` breaks it on one side."""
    mesh = mesh or sphere(4)
    x, y, z = mesh.vertices.T
    radius = 1 + 0.3 * y + 0.25 * z**3 + 0.2 * np.abs(x) ** 3 * y + 0.15 * y * z
    radius += bump * np.exp(-20 * ((x - 0.8) ** 2 + (y - 0.5) ** 2))
    return shuffled(replace(mesh, vertices=mesh.vertices * radius[:, None]))


@given(vectors.filter(lambda v: np.linalg.norm(v) > 0.1), vectors, st.integers(0, 99))
@settings(deadline=None)
def test_best_reflection_recovers_a_plane(normal, origin, seed):
    normal = normal / np.linalg.norm(normal)
    points = np.random.default_rng(seed).normal(size=(40, 3)) * [1, 2, 3] + origin
    images = reflect(points, normal, origin)
    found, centre = best_reflection(points, images)
    assert abs(found @ normal) == pytest.approx(1)
    assert reflect(points, found, centre) == pytest.approx(images, abs=1e-6)


@given(vectors.filter(lambda v: np.linalg.norm(v) > 0.1), vectors)
def test_reflecting_twice_is_nothing(normal, origin):
    points = np.arange(12.0).reshape(4, 3)
    normal = normal / np.linalg.norm(normal)
    assert reflect(reflect(points, normal, origin), normal, origin) == pytest.approx(points)


@pytest.mark.parametrize("turn", [(0, 0, 0), (0.4, -0.3, 1.1), (2.0, 0.5, -0.7)])
def test_symmetry_is_found_in_any_orientation(turn):
    mesh = blob()
    matrix = Rotation.from_rotvec(turn).as_matrix()
    found = mirror_map(replace(mesh, vertices=mesh.vertices @ matrix.T + [3, -2, 1]))
    slow = np.linalg.norm(mesh.vertices[:, None] * [-1, 1, 1] - mesh.vertices[None], axis=2).argmin(axis=1)
    assert (found == slow).mean() > 0.99
    assert (found[found] == np.arange(len(found))).mean() > 0.95


def test_without_symmetric_connectivity_the_nearest_vertex_is_taken():
    mesh = blob(mesh=irregular_sphere())
    slow = np.linalg.norm(mesh.vertices[:, None] * [-1, 1, 1] - mesh.vertices[None], axis=2).argmin(axis=1)
    assert (mirror_map(mesh) == slow).mean() > 0.7  # the plane is found up to the spacing of the vertices


def test_a_bump_on_one_side_is_no_symmetry():
    assert mirror_map(blob(bump=0.8, mesh=irregular_sphere())) is None


def test_symmetric_connectivity_survives_a_pose_that_is_not_symmetric():
    """The left half is pushed forward, further than any geometric tolerance."""
    mesh = blob()
    expected = mirror_map(mesh)
    pushed = mesh.vertices.copy()
    pushed[:, 2] += 0.5 * np.clip(pushed[:, 0] - 0.5, 0, None)
    posed = replace(mesh, vertices=pushed)
    assert np.array_equal(mirror_map(posed), expected)
    assert np.array_equal(expected[expected], np.arange(len(expected)))


def test_connectivity_is_followed_from_one_face():
    """A strip of two triangles: its only mirror image swaps the ends."""
    faces = np.array([[0, 1, 2], [2, 1, 3]])
    assert connectivity_mirror(faces, faces[0], np.array([3, 1, 2])).tolist() == [3, 1, 2, 0]
    assert connectivity_mirror(faces, faces[0], np.array([0, 2, 1])).tolist() == [0, 2, 1, 3]
    longer = np.array([[0, 1, 2], [2, 1, 3], [2, 3, 4]])
    assert connectivity_mirror(longer, longer[0], np.array([3, 1, 2])) is None


def test_a_single_face_has_axes_too():
    """Its area has no covariance; a triangle with equal legs is symmetric across their bisector."""
    found = mirror_map(shape([[0, 0, 0], [1, 0, 0], [0.5, 0, 1]], [[0, 1, 2]]))
    assert found is None or np.array_equal(found[found], np.arange(3))

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from datasets_gen import mirror_map
from datasets_gen.mirror import best_reflection, reflect, vertex_normals
from tests.datasets_gen.meshes import shuffled, sphere

vectors = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array)


def blob(bump=0.0):
    """A smooth closed surface whose only mirror plane is x = 0; `bump` breaks it on one side."""
    mesh = sphere(4)
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
    assert found is not None
    assert (found == slow).mean() > 0.99
    assert (found[found] == np.arange(len(found))).mean() > 0.95


def test_a_bump_on_one_side_is_no_symmetry():
    assert mirror_map(blob(bump=0.8)) is None


def test_normals_of_a_sphere_are_its_points():
    mesh = sphere(3)
    assert np.einsum("nd,nd->n", vertex_normals(mesh), mesh.vertices).min() > 0.999

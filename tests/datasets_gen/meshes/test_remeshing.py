import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from skimage.measure import marching_cubes

from datasets_gen.bodies.body_plan import Projector
from datasets_gen.bodies.implicit_surface import Body, ellipsoid
from datasets_gen.checks import edge_face_counts, signed_volume, winding_conflicts
from datasets_gen.meshes.remeshing import Edges, remesh
from tests.datasets_gen.sample_meshes import sphere

RADII = np.array([0.3, 0.4, 0.2])
BODY = Body((ellipsoid("b", (0, 0, 0), tuple(RADII), blend=0.02),))


def cubes(half, spacing=0.03):
    lower = np.array([0.0 if half else -0.45, -0.55, -0.35])
    axes = tuple(np.arange(lower[k], (0.45, 0.55, 0.35)[k], spacing) for k in range(3))
    nodes, faces, _, _ = marching_cubes(BODY.on_grid(axes, far=0.1), 0.0)
    return nodes.astype(float) * spacing + lower, faces.astype(np.int64)


def uniform(edge):
    return lambda points: np.full(len(points), edge)


def smallest_angles(vertices, faces):
    corners = vertices[faces]
    angles = []
    for k in range(3):
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        cosine = np.einsum("nd,nd->n", a, b) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
        angles.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return np.min(angles, axis=0)


@pytest.mark.parametrize("edge", [0.035, 0.06])
def test_closed_surface_becomes_regular_and_stays_on_the_surface(edge):
    vertices, faces = remesh(*cubes(half=False), uniform(edge), Projector(BODY), rounds=8)
    counts = edge_face_counts(faces)
    assert (counts == 2).all()
    assert len(vertices) - len(counts) + len(faces) == 2
    assert winding_conflicts(faces) == 0
    assert signed_volume(vertices, faces) > 0
    assert np.abs(BODY(vertices)).max() < 1e-4
    ends = Edges(faces).ends
    lengths = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)
    assert np.quantile(lengths, [0.01, 0.99]) == pytest.approx([0.8 * edge, 1.33 * edge], rel=0.25)
    assert np.quantile(smallest_angles(vertices, faces), 0.01) > 30


def test_sizes_follow_the_wish():
    def sizing(points):
        return np.where(points[:, 1] > 0, 0.03, 0.06)

    vertices, faces = remesh(*cubes(half=False), sizing, Projector(BODY), rounds=8)
    ends = Edges(faces).ends
    middle = vertices[ends].mean(axis=1)
    lengths = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)
    assert np.median(lengths[middle[:, 1] > 0.1]) == pytest.approx(0.03, rel=0.25)
    assert np.median(lengths[middle[:, 1] < -0.1]) == pytest.approx(0.06, rel=0.25)


def test_rim_of_a_half_stays_in_the_plane():
    vertices, faces = remesh(*cubes(half=True), uniform(0.05), Projector(BODY), rounds=8)
    counts = edge_face_counts(faces)
    rim = Edges(faces).boundary_vertices(len(vertices))
    assert rim.any()
    assert (vertices[rim, 0] == 0).all()
    assert (vertices[~rim, 0] > 0).all()
    assert len(vertices) - len(counts) + len(faces) == 1  # a disc
    assert np.abs(BODY(vertices)).max() < 1e-4


def test_same_input_gives_the_same_mesh():
    first = remesh(*cubes(half=True), uniform(0.05), Projector(BODY), rounds=3)
    second = remesh(*cubes(half=True), uniform(0.05), Projector(BODY), rounds=3)
    assert np.array_equal(first[0], second[0])
    assert np.array_equal(first[1], second[1])


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000), st.integers(0, 60))
def test_edges_agree_with_a_slow_search(seed, dropped):
    faces = np.random.default_rng(seed).permutation(sphere(1).faces.astype(np.int64))[dropped:]
    edges = Edges(faces)
    expected = {}
    for index, face in enumerate(faces):
        for k in range(3):
            pair = tuple(sorted((int(face[k]), int(face[(k + 1) % 3]))))
            expected.setdefault(pair, set()).add((index, int(face[(k + 2) % 3])))
    found = {
        tuple(ends): {(f, o) for f, o in zip(fs, os, strict=True) if f >= 0}
        for ends, fs, os in zip(
            edges.ends.tolist(), edges.faces.tolist(), edges.opposite.tolist(), strict=True
        )
    }
    assert found == expected
    assert edges.boundary.tolist() == [len(found[tuple(e)]) == 1 for e in edges.ends.tolist()]


def test_first_face_of_an_edge_runs_along_it():
    faces = sphere(1).faces.astype(np.int64)
    edges = Edges(faces)
    for (u, v), face in zip(edges.ends, edges.faces[:, 0], strict=True):
        corners = faces[face].tolist()
        assert corners[(corners.index(u) + 1) % 3] == v

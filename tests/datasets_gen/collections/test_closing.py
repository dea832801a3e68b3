import numpy as np
import pytest

from datasets_gen import InputError
from datasets_gen.checks import edge_face_counts, signed_volume, winding_conflicts
from datasets_gen.collections.closing import close, fill_holes, weld
from tests.datasets_gen.sample_meshes import sphere


def closed(faces):
    return (edge_face_counts(faces) == 2).all() and winding_conflicts(faces) == 0


def test_seams_are_welded():
    mesh = sphere(1)
    soup = mesh.vertices[mesh.faces].reshape(-1, 3)
    kept, faces = weld(soup, np.arange(len(soup)).reshape(-1, 3))
    assert len(kept) == len(mesh.vertices)
    assert closed(faces)
    np.testing.assert_array_equal(soup[kept][faces], mesh.vertices[mesh.faces])
    assert (np.diff(kept) > 0).all()


def test_a_sphere_without_a_vertex_is_closed_again():
    mesh = sphere(2)
    open_faces = mesh.faces[(mesh.faces != 17).all(axis=1)].astype(np.int64)
    faces = fill_holes(mesh.vertices, open_faces)
    assert closed(faces)
    missing = (mesh.faces == 17).any(axis=1).sum()
    assert len(faces) == len(open_faces) + missing - 2  # a rim of n edges takes n - 2 triangles
    assert signed_volume(mesh.vertices, faces) == pytest.approx(
        signed_volume(mesh.vertices, mesh.faces), rel=0.02
    )


def test_fans_use_no_edge_that_is_there():
    """A flat strip 0 1 2 3 whose far side has the diagonal 0 2 already: the hole takes the other one."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    filled = fill_holes(vertices, np.array([[0, 2, 1], [0, 3, 2]]))
    assert closed(filled)
    assert {frozenset(face) for face in filled[2:].tolist()} == {frozenset((0, 1, 3)), frozenset((1, 2, 3))}


def test_a_mesh_without_holes_stays():
    mesh = sphere(1)
    np.testing.assert_array_equal(fill_holes(mesh.vertices, mesh.faces.astype(np.int64)), mesh.faces)


def test_small_parts_and_folds_are_left_out():
    mesh, speck = sphere(3), sphere(0)
    a, b, c = mesh.faces[40]
    vertices = np.concatenate([mesh.vertices, speck.vertices * 0.1])
    faces = np.concatenate([mesh.faces, speck.faces + len(mesh.vertices), [[a, b, c], [c, b, a]]]).astype(
        np.int64
    )
    kept, result = close(vertices, faces, "test")
    assert closed(result)
    np.testing.assert_array_equal(kept, np.setdiff1d(np.arange(len(mesh.vertices)), (a, b, c)))
    assert signed_volume(vertices[kept], result) == pytest.approx(4 / 3 * np.pi, rel=0.05)


def test_holes_that_meet_are_told():
    mesh = sphere(2)
    first = mesh.faces[0]
    shared = first[0]
    ring = mesh.faces[(mesh.faces == shared).any(axis=1)]
    apart = next(face for face in ring if len(set(face) & set(first)) == 1)
    drop = [0, int(np.flatnonzero((mesh.faces == apart).all(axis=1))[0])]
    with pytest.raises(InputError, match="two holes"):
        fill_holes(mesh.vertices, np.delete(mesh.faces, drop, axis=0).astype(np.int64))

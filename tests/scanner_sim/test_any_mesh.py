"""Whatever triangle mesh has a surface is scanned, and only its surface counts."""

import logging
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from datasets_gen import InputError, load_mesh
from scanner_sim import ScannerConfig, coverage, sample, scan
from tests.scanner_sim.conftest import to_shape

SMALL = ScannerConfig(views=4, resolution=(80, 80))


def ball(radius=10.0, place=(0.0, 0.0, 0.0)):
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    mesh.apply_translation(place)
    return mesh


@pytest.mark.parametrize("stray", [[1e4, 0, 0], [np.nan, 0, 0], [np.inf] * 3])
def test_vertices_of_no_face_change_nothing(stray):
    """The same triangles in the same place, whatever else the file holds."""
    plain = to_shape(ball())
    given = replace(plain, vertices=np.vstack([plain.vertices, [stray], [[0, -1e3, 0]]]))
    found, wanted = scan(given, SMALL), scan(plain, SMALL)
    assert np.array_equal(found.points, wanted.points)
    assert np.array_equal(found.face_ids, wanted.face_ids)
    assert found.scale == wanted.scale
    assert coverage(found, given) == coverage(wanted, plain)
    assert np.array_equal(sample(given, 50).points, sample(plain, 50).points)


def test_faces_without_area_are_ignored_and_said(caplog):
    plain = to_shape(ball())
    last = len(plain.vertices)
    vertices = np.vstack([plain.vertices, [[1e4, 0, 0]]])
    flat = [[0, 0, last], [3, 3, 3], [5, last, 5]]
    given = replace(plain, vertices=vertices, faces=np.vstack([flat, plain.faces]).astype(np.int32))
    with caplog.at_level(logging.WARNING):
        found = scan(replace(given, subject="flat"), SMALL)
    assert "3 degenerate faces (no area) are ignored" in caplog.text
    wanted = scan(plain, SMALL)
    assert np.array_equal(found.points, wanted.points)
    assert np.array_equal(found.face_ids, wanted.face_ids + 3)
    with pytest.raises(InputError, match="extent"):
        scan(replace(given, faces=given.faces[:3]), SMALL)


def test_several_pieces_are_scanned_each():
    """Two balls seen from above hide nothing of each other: each gives about half the points."""
    pair = to_shape(trimesh.util.concatenate([ball(), ball(place=(30, 0, 0))]))
    found = scan(pair, ScannerConfig(views=((0, 0, 1),), resolution=(100, 100)))
    right = found.true_points[:, 0] > 15
    for mine, centre in ((~right, 0), (right, 30)):
        radii = np.linalg.norm(found.true_points[mine] - [centre, 0, 0], axis=1)
        assert radii == pytest.approx(10, abs=0.05)
    assert 0.3 < right.mean() < 0.7


def fin():
    """A ball with a triangle on one of its edges, which then has three faces."""
    mesh = ball()
    out = 1.5 * mesh.vertices[mesh.faces[0][0]]
    corners = [*mesh.faces[0][:2], len(mesh.vertices)]
    return trimesh.Trimesh(
        np.vstack([mesh.vertices, [out]]), np.vstack([mesh.faces, [corners]]), process=False
    )


def bowl():
    """The lower half of a ball, open above, its normals into the bowl as a scanner above it needs them."""
    mesh = ball()
    faces = mesh.faces[mesh.triangles_center[:, 2] < 0][:, ::-1]
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


MESHES = {
    "two pieces": trimesh.util.concatenate([ball(), ball(4, (20, 0, 0))]),
    "edge of three faces": fin(),
    "open": bowl(),
    "flat sheet": trimesh.Trimesh(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], process=False
    ),
}


@pytest.mark.parametrize("name", MESHES)
def test_files_are_scanned_as_shapes_are(name, tmp_path):
    MESHES[name].export(tmp_path / "mesh.obj", digits=17)
    config = ScannerConfig(views=((0, 0, 1), (1, 0, 1)), resolution=(80, 80))
    found = scan(load_mesh(tmp_path / "mesh.obj", strict=False), config)
    wanted = scan(to_shape(MESHES[name]), config)
    assert len(wanted) > 200
    assert np.array_equal(found.points, wanted.points)
    assert np.array_equal(found.face_ids, wanted.face_ids)


def test_a_relief_keeps_its_side_and_a_closed_body_is_turned(caplog):
    """The bowl's volume about its centroid is negative, yet it is no body that was turned inside out."""
    found = scan(to_shape(bowl()), ScannerConfig(views=((0, 0, 1),), resolution=(80, 80)))
    assert (found.normals[:, 2] > 0).all()
    holed = ball()
    holed = trimesh.Trimesh(holed.vertices, holed.faces[4:, ::-1], process=False)
    with caplog.at_level(logging.WARNING):
        turned = scan(to_shape(holed), SMALL)
    assert "look inward" in caplog.text
    assert np.einsum("nd,nd->n", turned.normals, turned.true_points).min() > 0


def test_scans_are_written_as_what_they_are_called(tmp_path):
    whole = sample(to_shape(ball()), 20)
    for name in ("scan.npz", "scan.PLY"):
        whole.save(tmp_path / name)
    for name in ("scan.xyz", "scan", "scan.npz.gz"):
        with pytest.raises(InputError, match=r"\.npz, \.ply"):
            whole.save(tmp_path / name)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["scan.PLY", "scan.npz"]

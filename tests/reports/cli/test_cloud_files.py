"""Files as users hold them: what match makes of each, against the surface that they were taken from."""

import logging

import numpy as np
import pytest
import trimesh

from datasets_gen import InputError
from datasets_gen.meshes.files import read_mesh
from datasets_gen.points.fibonacci import fibonacci_sphere
from reports.cli.cloud_files import CLOUD_SUFFIXES, centred, read_cloud, read_thinned, with_normals
from reports.given_clouds import as_cloud
from scanner_sim import Scan

AXES = np.array([1.0, 0.6, 0.3])
BALL = fibonacci_sphere(8000) * AXES
OUTWARD = BALL / AXES**2 / np.linalg.norm(BALL / AXES**2, axis=1, keepdims=True)
"""Of an ellipsoid."""


def right(normals, truth=OUTWARD):
    return float((np.einsum("nd,nd->n", normals, truth) > 0).mean())


@pytest.mark.parametrize(
    ("offset", "kind"),
    [((5e5, 5.4e6, 300), np.float64), ((300, 300, 300), np.float32), ((5e5, 0, 0), np.float32)],
)
def test_large_offsets_leave_normals_outward(tmp_path, caplog, offset, kind):
    """At 5e5 single precision has steps of 0.03: half of the points share a place with another."""
    np.save(tmp_path / "a.npy", (BALL + np.array(offset)).astype(kind))
    found = read_cloud(tmp_path / "a.npy", 100)
    assert right(found.normals) > (0.94 if offset[0] == 5e5 and kind is np.float32 else 0.999)
    assert ("steps of 0.0312" in caplog.text) == (offset[0] == 5e5 and kind is np.float32)


def test_where_rounding_left_no_surface_normals_are_not_guessed(tmp_path, caplog):
    far = (BALL + np.array([5e5, 5.4e6, 300])).astype(np.float32)
    np.save(tmp_path / "a.npy", far)
    with pytest.raises(
        InputError, match=r"a\.npy' has no normals, and none can be estimated: .* y has steps of 0\.5"
    ):
        read_cloud(tmp_path / "a.npy", 100)
    np.save(tmp_path / "b.npy", np.hstack([far, OUTWARD]))  # given ones are kept, and the loss is said
    assert np.allclose(read_cloud(tmp_path / "b.npy", 100).normals, OUTWARD)
    assert "y has steps of 0.5" in caplog.text


def test_copies_of_points_leave_normals_outward(tmp_path):
    np.save(tmp_path / "a.npy", np.repeat(BALL[::4], 18, axis=0))
    found = read_thinned(tmp_path / "a.npy", 2000)
    assert right(found.scan.normals, OUTWARD[::4][found.kept // 18]) > 0.999
    assert len(np.unique(found.kept // 18)) == 2000  # each place once
    assert not found.stray.any()


def test_points_and_normals_that_are_no_numbers(tmp_path, caplog):
    table = np.hstack([BALL, OUTWARD])
    table[10, 1], table[20:23, 3:], table[30, 4] = np.nan, 0, np.nan
    np.savetxt(tmp_path / "a.xyz", table)
    found = read_cloud(tmp_path / "a.xyz", 100)
    kept = np.arange(8000) != 10
    assert np.allclose(found.points, BALL[kept])
    assert (np.einsum("nd,nd->n", found.normals, OUTWARD[kept]) > 0.99).all()
    assert "1 point of 8,000 NaN or infinite, the first is number 10: dropped" in caplog.text
    assert "4 normals of 7,999 zero or NaN: estimated from their neighbours" in caplog.text


def test_normals_of_an_off_are_kept(tmp_path):
    inward = "".join(
        " ".join(f"{v:.9g}" for v in (*p, *-n)) + "\n" for p, n in zip(BALL, OUTWARD, strict=True)
    )
    (tmp_path / "a.off").write_text("NOFF\n8000 0 0\n" + inward)
    assert np.allclose(read_cloud(tmp_path / "a.off", 100).normals, -OUTWARD, atol=1e-6)


def dressed(folder):
    """A ball with a hole, a floor below it, a face without area, and vertices of no face."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    faces = ball.faces[ball.vertices[ball.faces].mean(axis=1)[:, 0] < 0.9]
    floor = np.array([[-2, -2, -1.2], [2, -2, -1.2], [2, 2, -1.2], [-2, 2, -1.2], [9, 9, 9.0]])
    n = len(ball.vertices)
    more = [[n, n + 1, n + 2], [n, n + 2, n + 3], [n, n, n + 1]]
    mesh = trimesh.Trimesh(np.vstack([ball.vertices, floor]), np.vstack([faces, more]), process=False)
    mesh.export(folder / "dressed.ply")
    return folder / "dressed.ply", mesh


def test_a_mesh_in_pieces_with_holes_is_sampled_as_it_is(tmp_path, caplog):
    path, mesh = dressed(tmp_path)
    found = read_thinned(path, 3000)
    assert found.what == "samples"
    assert len(found.points) == 3000
    on_floor = np.isclose(found.points[:, 2], -1.2)
    assert on_floor.mean() == pytest.approx(16 / mesh.area, abs=0.03)  # as large as its area
    assert np.allclose(np.linalg.norm(found.points[~on_floor], axis=1), 1, atol=0.02)
    assert not found.stray.any()
    for words in ("2 pieces", "open boundary", "1 degenerate faces", "belong to no face"):
        assert words in caplog.text
    assert np.abs(read_thinned(path, 3000, repair=True).points).max() < 1.001  # the largest piece


def test_each_vertex_of_a_mesh_is_a_point(tmp_path, caplog):
    path, mesh = dressed(tmp_path)
    found = read_thinned(path, 300, on="vertices")
    assert found.what == "vertices"
    assert np.allclose(found.points, mesh.vertices)
    used = np.zeros(len(mesh.vertices), dtype=bool)
    used[mesh.faces[:-1]] = True
    corners = np.arange(len(used)) >= len(used) - 5  # four of the floor, far from all other vertices
    assert np.array_equal(found.stray, ~used | corners)
    assert not found.stray[found.kept].any()
    assert len(found.kept) == 300
    ball = found.points[found.kept]
    ball, normals = ball[ball[:, 2] > -1.1], found.scan.normals[ball[:, 2] > -1.1]
    assert (np.einsum("nd,nd->n", ball, normals) > 0.95).all()
    assert f"{np.count_nonzero(~used)} vertices of no face with area: not matched" in caplog.text
    with pytest.raises(InputError, match="--on vertices keeps them all; choose one"):
        read_thinned(path, 300, repair=True, on="vertices")


def test_vertices_of_no_face_that_are_no_numbers_are_refused(tmp_path):
    content = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (tmp_path / "a.obj").write_text(content)
    with pytest.raises(InputError, match=r"a\.obj' has 4 points: too few; give at least 8"):
        read_thinned(tmp_path / "a.obj", 20, on="vertices")
    np.savez(tmp_path / "a.npz", points=[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, np.nan]], faces=[[0, 1, 2]])
    with pytest.raises(InputError, match="1 vertex of no face that are NaN or infinite"):
        read_thinned(tmp_path / "a.npz", 20, on="vertices")
    assert len(read_thinned(tmp_path / "a.npz", 20).points) == 20


def test_the_order_of_vertices_is_that_of_the_file(tmp_path):
    mesh = trimesh.creation.icosphere(subdivisions=2)
    mesh.export(tmp_path / "a.ply")
    assert np.array_equal(
        read_thinned(tmp_path / "a.ply", 10_000, on="vertices").points, read_mesh(tmp_path / "a.ply").vertices
    )


def test_clouds_near_the_origin_are_not_moved():
    assert centred(BALL) is BALL
    assert np.allclose(centred(BALL + 1e6), BALL, atol=0.02)


def test_a_scan_with_sound_normals_is_the_very_same(scan_file, caplog):
    scan = Scan.load(scan_file)
    with caplog.at_level(logging.WARNING):
        assert with_normals(scan, "it") is scan
    assert caplog.text == ""


def test_endings():
    assert {".npz", ".ply", ".stl", ".glb", ".xyz", ".csv", ".pcd", ".npy", ".las"} <= set(CLOUD_SUFFIXES)


def test_meshes_in_memory_are_sampled_as_those_in_files_are(tmp_path):
    """What ``medialbench.match`` takes: a path by the same reader, arrays in pieces and open."""
    path, mesh = dressed(tmp_path)
    shown = as_cloud((np.asarray(mesh.vertices), np.asarray(mesh.faces)), 500)
    assert np.allclose(shown.points, as_cloud(path, 500).points, atol=1e-6)
    table = np.hstack([BALL, np.tile([255, 0, 17], (8000, 1))])
    np.savetxt(tmp_path / "a.txt", table)
    assert right(as_cloud(tmp_path / "a.txt").normals) > 0.999

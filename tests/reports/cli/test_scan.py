"""Scanning meshes; bad input ends in one line with nothing written."""

import importlib

import numpy as np
import pytest
import trimesh

import medialbench
from scanner_sim import Scan
from tests.reports.cli.command_line import SMALL, body, fails, run


def test_scan_writes_all_that_a_scan_knows(scan_file):
    scan = Scan.load(scan_file)
    assert len(scan) == 600
    assert scan.config.peak_threshold == 0.3
    assert scan.config.resolution == (60, 60)
    assert scan.config.views == 4
    assert (scan.intensity >= 0.3).all()


def test_quiet_scans_say_nothing_and_repeat_exactly(mesh_file, tmp_path):
    files = [tmp_path / "a.npz", tmp_path / "b.npz"]
    for path in files:
        result = run("scan", mesh_file, "-o", path, *SMALL, "--set", "noise=0.2", "--seed", 5, "-q")
        assert result.exit_code == 0
        assert result.output == ""
    a, b = map(Scan.load, files)
    assert np.array_equal(a.points, b.points)
    assert np.array_equal(a.intensity, b.intensity)


def test_scan_writes_ply_preview_and_range_images(mesh_file, tmp_path):
    result = run(
        "scan", mesh_file, "-o", tmp_path / "s.ply", *SMALL, "--preview", tmp_path / "sheet.png",
        "--range-images", tmp_path / "ranges",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    cloud = trimesh.load(tmp_path / "s.ply")
    assert np.abs(cloud.vertices).max() < 2.5
    assert (tmp_path / "sheet.png").read_bytes()[:4] == b"\x89PNG"
    assert "cameras.json" in [path.name for path in (tmp_path / "ranges").iterdir()]


def with_nan(mesh):
    mesh.vertices[3] = np.nan
    return mesh


def with_flat_face(mesh):
    return trimesh.Trimesh(mesh.vertices, np.vstack([mesh.faces, [[0, 0, 1]]]), process=False)


def non_manifold(mesh):
    faces = np.vstack([mesh.faces, [[mesh.faces[0][0], mesh.faces[0][1], 100]]])
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


def in_two_parts(mesh):
    other = mesh.copy()
    other.apply_translation([5, 0, 0])
    return trimesh.util.concatenate([mesh, other])


def with_flat_faces_alone(mesh):
    return trimesh.Trimesh(mesh.vertices, [[0, 0, 1], [2, 2, 2]], process=False)


BAD_MESHES = {"NaN": (with_nan, "NaN"), "no area": (with_flat_faces_alone, "degenerate")}
ODD_MESHES = {"degenerate": with_flat_face, "non-manifold": non_manifold, "two parts": in_two_parts}


@pytest.mark.parametrize("name", BAD_MESHES)
def test_bad_meshes_are_refused(name, tmp_path):
    spoil, word = BAD_MESHES[name]
    path, out = tmp_path / "bad.ply", tmp_path / "out" / "scan.npz"
    spoil(body()).export(path)
    fails(run("scan", path, "-o", out, *SMALL), word)
    assert not out.parent.exists()


@pytest.mark.parametrize("name", ODD_MESHES)
def test_any_mesh_with_a_surface_is_scanned_as_from_python(name, tmp_path):
    path, out = tmp_path / "odd.ply", tmp_path / "scan.npz"
    ODD_MESHES[name](body()).export(path)
    result = run("scan", path, "-o", out, *SMALL)
    assert result.exit_code == 0, result.output
    found = Scan.load(out)
    wanted = medialbench.scan(path, views=4, resolution=(60, 60), stripes=80)
    assert np.array_equal(found.points, wanted.points)
    assert np.array_equal(found.face_ids, wanted.face_ids)


def test_files_that_are_no_meshes_are_refused(tmp_path, scan_file):
    out = tmp_path / "scan.npz"
    (tmp_path / "cloud.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 1\n"
        "property float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n"
    )
    (tmp_path / "text.obj").write_bytes(b"\x00\x01 nonsense")
    (tmp_path / "mesh.stl").write_text("solid")
    fails(run("scan", tmp_path / "cloud.ply", "-o", out), "faces")
    fails(run("scan", tmp_path / "text.obj", "-o", out), "text.obj")
    fails(run("scan", tmp_path / "mesh.stl", "-o", out), ".stl")
    fails(run("scan", tmp_path, "-o", out))
    fails(run("scan", scan_file, "-o", out), "Scan")
    assert not out.exists()


def test_repair_goes_on_with_the_largest_part(tmp_path):
    path, out = tmp_path / "two.ply", tmp_path / "s.npz"
    big = body()
    small = trimesh.creation.icosphere(subdivisions=1)
    small.apply_translation([9, 0, 0])
    trimesh.util.concatenate([big, small]).export(path)
    assert run("scan", path, "-o", out, *SMALL).exit_code == 0
    assert Scan.load(out).points[:, 0].max() > 8
    assert run("scan", path, "-o", out, *SMALL, "--repair").exit_code == 0
    assert Scan.load(out).points[:, 0].max() < 5


@pytest.mark.parametrize("value", ["0", "-0.5", "1.5", "nan"])
def test_thresholds_outside_the_range_are_refused(value, mesh_file, tmp_path):
    out = tmp_path / "s.npz"
    fails(run("scan", mesh_file, "-o", out, "-t", value), "threshold", value)
    assert not out.exists()


def test_impossible_settings_are_refused(mesh_file, tmp_path):
    out = tmp_path / "s.npz"
    fails(run("scan", mesh_file, "-o", out, "--views", "0"), "views")
    fails(run("scan", mesh_file, "-o", out, "--views", "some"), "views")
    fails(run("scan", mesh_file, "-o", out, "--set", "colour=1"), "colour")
    fails(run("scan", mesh_file, "-o", out, "--set", "noise"), "NAME=VALUE", status=2)
    fails(run("scan", mesh_file, "-o", out, *SMALL, "--set", "baseline=0"), "baseline")
    fails(run("scan", mesh_file, "-o", out, *SMALL, "-t", "1.0"), "acquired")  # no view sees anything
    assert not out.exists()


@pytest.mark.parametrize(
    ("views", "wanted"),
    [
        ("2", 2),
        ("ring:3", "ring:3"),
        ("[[0,0,1]]", ((0, 0, 1),)),
        ("[[0,0,1], [1,.5,0]]", ((0, 0, 1), (1, 0.5, 0))),
    ],
)
def test_views_are_a_number_a_name_or_directions(views, wanted, mesh_file, tmp_path):
    out = tmp_path / "s.npz"
    result = run("scan", mesh_file, "-o", out, *SMALL[:4], "--views", views)
    assert result.exit_code == 0, result.output
    assert Scan.load(out).config.views == wanted


def test_numbers_are_read_as_people_write_them(mesh_file, tmp_path):
    out = tmp_path / "s.npz"
    result = run("scan", mesh_file, "-o", out, *SMALL, "--set", "peak_threshold=.5", "--set", "gain=1.")
    assert result.exit_code == 0, result.output
    assert Scan.load(out).config.peak_threshold == 0.5
    fails(run("scan", mesh_file, "-o", out, *SMALL, "--set", "peak_threshold=-.5"), "-0.5")


def test_a_setting_given_twice_is_refused(mesh_file, tmp_path):
    out = tmp_path / "s.npz"
    result = run("scan", mesh_file, "-o", out, "--views", "2", "--set", "views=ring:3")
    fails(result, "--views 2", "--set views=ring:3", "one of them", status=2)
    result = run("scan", mesh_file, "-o", out, "-t", "0.4", "--set", "peak_threshold=.5")
    fails(result, "--peak-threshold 0.4", "--set peak_threshold=0.5", status=2)
    assert not out.exists()


def test_views_that_see_nothing_are_said_in_one_line(tmp_path):
    path, out = tmp_path / "sheet.ply", tmp_path / "s.npz"
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False).export(path)
    result = run("scan", path, "-o", out, *SMALL[:4], "--views", "[[0, 0, 1], [0, 0, -1], [1, 0, -3]]")
    assert result.exit_code == 0, result.output
    said = [line for line in result.stderr.splitlines() if "see nothing" in line]
    assert len(said) == 1
    assert "[1, 2]" in said[0]


def test_an_open_surface_is_scanned_and_its_boundary_said(tmp_path):
    path, out = tmp_path / "open.ply", tmp_path / "s.npz"
    ball = trimesh.creation.icosphere(subdivisions=3)
    trimesh.Trimesh(ball.vertices, ball.faces[ball.triangles_center[:, 1] > 0], process=False).export(path)
    result = run("scan", path, "-o", out, *SMALL)
    assert result.exit_code == 0, result.output
    assert "open boundary of" in result.stderr
    assert len(Scan.load(out)) > 100


def test_a_huge_scan_suggests_to_keep_fewer_points(mesh_file, tmp_path, monkeypatch):
    command = importlib.import_module("reports.cli.scan")  # as an attribute, `scan` is the command
    monkeypatch.setattr(command, "HUGE", 500)
    many = run("scan", mesh_file, "-o", tmp_path / "s.npz", *SMALL)
    assert "points are many: --points 20000 keeps" in many.output
    few = run("scan", mesh_file, "-o", tmp_path / "s.npz", *SMALL, "--points", 400)
    assert "points are many" not in few.output

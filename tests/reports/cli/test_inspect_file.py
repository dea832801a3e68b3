"""What ``inspect`` says of files, against what is known of them."""

import json

import numpy as np
import pytest
import trimesh

from datasets_gen.points.fibonacci import fibonacci_sphere
from scanner_sim import Scan
from tests.reports.cli.command_line import fails, run

BALL = fibonacci_sphere(2000)


def facts(path, *more):
    result = run("inspect", path, "--json", *more)
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def test_a_ball_of_points(tmp_path):
    """Each of n even points has a square of 4 pi / n for itself."""
    points = np.concatenate([BALL, BALL[:10], [[40.0, 0, 0]], [[np.nan, 0, 0]]])
    np.save(tmp_path / "a.npy", points)
    found = facts(tmp_path / "a.npy")
    cloud = found["points"]
    assert (found["kind"], cloud["points"], cloud["copies"], cloud["stray"]) == ("cloud", 2011, 10, 1)
    assert cloud["groups"] == 1
    assert cloud["spacing"][0] == pytest.approx(np.sqrt(4 * np.pi / 2000), rel=0.1)
    assert np.allclose(cloud["high"], [40, BALL[:, 1].max(), BALL[:, 2].max()])
    assert cloud["units"] == "m"
    assert found["normals"] == {"source": "estimated", "lacking": 0, "outward": pytest.approx(1, abs=0.01)}
    assert found["missing"]["share"] == pytest.approx(0, abs=0.1)
    assert found["match"]["matched"] == 2010
    assert any("1 point of 2,012 NaN or infinite" in line for line in found["remarks"])
    assert any("has no normals: estimated" in line for line in found["match"]["warnings"])
    assert any("far from all others" in line for line in found["match"]["warnings"])
    assert "no faces" in found["scan"]["refused"]


@pytest.mark.parametrize("kept", [0.75, 0.5])
def test_the_share_of_a_ball_that_is_missing(tmp_path, kept):
    """A cap of height h has the share h / 2 of the area."""
    cap = BALL[BALL[:, 1] < 2 * kept - 1]
    np.savez(tmp_path / "a.npz", points=cap, normals=cap)
    assert facts(tmp_path / "a.npz")["missing"]["share"] == pytest.approx(1 - kept, abs=0.2)


def test_normals_that_look_inward_or_are_lacking(tmp_path):
    normals = np.where(np.arange(2000)[:, None] == 5, 0, -BALL)
    np.savez(tmp_path / "a.npz", points=1000 * BALL, normals=normals)
    found = facts(tmp_path / "a.npz")
    assert found["normals"] == {"source": "given", "lacking": 1, "outward": pytest.approx(0, abs=0.01)}
    assert found["points"]["units"] == "mm"
    assert any("point inward: flipped" in line for line in found["match"]["warnings"])


def test_coordinates_that_single_precision_has_rounded_away(tmp_path):
    np.save(tmp_path / "a.npy", (BALL + np.array([5e5, 5.4e6, 300])).astype(np.float32))
    found = facts(tmp_path / "a.npy")
    assert found["points"]["rounding"]["single"]
    assert found["points"]["rounding"]["steps"][1] == 0.5
    assert "none can be estimated" in found["match"]["refused"]
    assert found["missing"]["share"] is None
    text = run("inspect", tmp_path / "a.npy").stdout
    assert "y has steps of 0.5" in text


def broken(path):
    """A ball without two caps of known rims, a face more on an edge, one flat, one twice; a loose vertex."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    height = ball.vertices[ball.faces].mean(axis=1)[:, 2]
    faces = ball.faces[np.abs(height) < 0.8]
    n = len(ball.vertices)
    more = [[faces[0][0], faces[0][1], n], [faces[1][0]] * 3, faces[5]]
    mesh = trimesh.Trimesh(np.vstack([ball.vertices, [[3, 0, 0]]]), np.vstack([faces, more]), process=False)
    mesh.export(path)
    return mesh, faces


def test_a_mesh_with_all_kinds_of_faults(tmp_path):
    mesh, faces = broken(tmp_path / "a.ply")
    found = facts(tmp_path / "a.ply")
    got = found["mesh"]
    assert found["kind"] == "mesh"
    assert (got["vertices"], got["faces"], got["degenerate"], got["repeated"]) == (643, len(faces) + 3, 1, 1)
    assert got["unreferenced"] == 643 - len(np.unique(mesh.faces))
    assert got["pieces"] == 1
    assert got["crowded_edges"] >= 1
    assert got["caps"] is None  # faces on a crowded edge have no common winding
    assert found["scan"]["refused"] is None
    assert "1 degenerate faces" in found["scan"]["truth"]
    text = run("inspect", tmp_path / "a.ply").stdout
    for words in ("1 without area, 1 repeated", "of more than two faces", "as ground truth:", "match warns:"):
        assert words in text


def test_caps_over_the_boundaries_of_a_mesh(tmp_path):
    """An open cylinder of radius 1 and height 2: its lids are 2 pi of 6 pi."""
    tube = trimesh.creation.cylinder(radius=1, height=2, sections=64)
    faces = tube.faces[np.abs(tube.face_normals[:, 2]) < 0.5]
    trimesh.Trimesh(tube.vertices, faces, process=False).export(tmp_path / "a.off")
    got = facts(tmp_path / "a.off")["mesh"]
    assert (got["boundary_loops"], got["boundary_edges"]) == (2, 128)
    assert got["caps"] == pytest.approx(1 / 3, rel=0.01)
    assert not got["inward"]


def test_a_sound_mesh_and_a_scan(mesh_file, scan_file):
    found = facts(mesh_file)
    assert found["mesh"]["boundary_edges"] == found["mesh"]["crowded_edges"] == 0
    assert found["missing"] == {"share": 0.0, "how": "the mesh is closed"}
    assert found["scan"] == {"refused": None, "warnings": [], "truth": "ok"}
    scan = facts(scan_file)
    assert scan["kind"] == "scan"
    assert scan["points"]["points"] == len(Scan.load(scan_file))
    assert scan["match"]["refused"] is None


def test_files_that_cannot_be_read_are_one_line(tmp_path, scan_file):
    fails(run("inspect", tmp_path / "none.ply"), "does not exist")
    (tmp_path / "a.txt").write_text("1,5,2,5,3,5\n")
    fails(run("inspect", tmp_path / "a.txt"), "line 1, can be read in two ways")
    assert facts(tmp_path / "a.txt", "--columns", "x y z r g b")["points"]["points"] == 1


def test_coordinates_beyond_what_can_be_computed_with_are_refused(tmp_path):
    np.save(tmp_path / "a.npy", BALL * 1e160)
    fails(run("inspect", tmp_path / "a.npy"), "has a coordinate of 1e+160", "choose larger units")


def test_an_array_that_a_user_calls_kind_makes_no_record(tmp_path):
    np.savez(tmp_path / "a.npz", points=BALL, kind="person")
    assert facts(tmp_path / "a.npz")["points"]["points"] == len(BALL)

"""Maps of the vertices of mesh files, and of real scans: in pieces, open, in any format."""

import numpy as np
import pytest
import trimesh

from datasets_gen.correspondences.reading import read_map
from datasets_gen.records import load_record
from tests.reports.cli.command_line import FAST, body, fails, run


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    """An open body on a floor; its last vertex has no face."""
    mesh = body()
    faces = mesh.faces[mesh.vertices[mesh.faces].mean(axis=1)[:, 2] < 0.35]
    floor = trimesh.creation.box((2, 0.01, 2)).subdivide().subdivide()
    floor.apply_translation([0, mesh.vertices[:, 1].min() - 0.1, 0])
    whole = trimesh.util.concatenate([trimesh.Trimesh(mesh.vertices, faces, process=False), floor])
    vertices = np.vstack([whole.vertices, [[0, 0, 0]]])
    path = tmp_path_factory.mktemp("parts") / "parts.ply"
    trimesh.Trimesh(vertices, whole.faces, process=False).export(path)
    return path, vertices


def test_a_map_in_text_has_a_line_for_each_vertex(parts, tmp_path):
    path, vertices = parts
    out = tmp_path / "m.map"
    result = run("match", path, path, "-o", out, *FAST)
    assert result.exit_code == 0, result.output
    count = len(vertices)
    assert f"; source: {count:,} vertices, target: {count:,} vertices; written to" in result.stderr
    for words in ("2 pieces", "open boundary", "belong to no face", "of no face with area: not matched"):
        assert words in result.stderr
    found = read_map(out)
    assert len(found) == count
    gap = np.linalg.norm(vertices - vertices[found.ids], axis=1)
    used = np.arange(count) < count - 1
    assert np.median(gap[used]) < 0.1
    assert found.ids.max() < count


def test_samples_are_matched_for_npz_and_where_asked_for(parts, tmp_path):
    path, _ = parts
    result = run("match", path, path, "-o", tmp_path / "m.npz", *FAST)
    assert result.exit_code == 0, result.output
    assert "; source: 400 samples, target: 400 samples; written to" in result.stderr
    arrays, meta = load_record(tmp_path / "m.npz", "Matching")
    assert len(arrays["source_to_target"]) == 400
    assert (meta["about"]["source"], meta["about"]["target"]) == ("samples", "samples")


def test_vertices_and_repair_do_not_go_together(parts, tmp_path):
    given = ("match", parts[0], parts[0], "-o", tmp_path / "m.npz")
    fails(run(*given, "--on", "vertices", "--repair"), "--repair drops vertices", "choose one")
    fails(run(*given, "--on", "corners"), "'corners'", status=2)
    assert not (tmp_path / "m.npz").exists()


def test_symmetry_of_vertices(parts, tmp_path):
    path, vertices = parts
    out = tmp_path / "s.csv"
    result = run("symmetry", path, "-o", out, *FAST)
    assert result.exit_code == 0, result.output
    assert len(read_map(out)) == len(vertices)
    assert f"source: {len(vertices):,} vertices" in result.stderr


def test_columns_can_be_named(scan_file, tmp_path):
    from scanner_sim import Scan

    scan = Scan.load(scan_file)
    np.savetxt(tmp_path / "a.txt", np.hstack([scan.normals, scan.points]))
    names = ("--columns", "nx ny nz x y z")
    result = run("match", tmp_path / "a.txt", tmp_path / "a.txt", "-o", tmp_path / "m.npz", *FAST, *names)
    assert result.exit_code == 0, result.output
    assert np.allclose(load_record(tmp_path / "m.npz", "Matching")[0]["source_points"], scan.points)
    fails(run("match", scan_file, tmp_path / "a.txt", "--columns", "x y"), "do not name x, y and z")

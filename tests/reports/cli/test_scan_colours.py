"""Colours of a file reach the scan: from the command line and from Python."""

import numpy as np
from PIL import Image

import medialbench
from scanner_sim import Scan
from tests.reports.cli.command_line import SMALL, body, fails, run

COLOURED = ["--set", "material=colours", "--set", "peak_threshold=0.02"]


def test_vertex_colours_dim_the_scan(tmp_path):
    """Half of the body is dark: linear 118 over linear 255 is .18."""
    mesh = body()
    top = mesh.vertices[:, 1] > 0
    mesh.visual.vertex_colors = np.where(top[:, None], 255, 118).astype(np.uint8).repeat(3, axis=1)
    mesh.export(tmp_path / "c.ply")
    result = run("scan", tmp_path / "c.ply", "-o", tmp_path / "c.npz", *SMALL, *COLOURED)
    assert result.exit_code == 0, result.output
    found = Scan.load(tmp_path / "c.npz")
    y = found.true_points[:, 1]
    assert found.intensity[y > 0.2].max() > 0.9
    assert 0.12 < found.intensity[y < -0.2].max() < 0.2
    again = medialbench.scan(
        mesh, threshold=0.02, views=4, resolution=(60, 60), stripes=80, material="colours"
    )
    assert np.allclose(again.intensity, found.intensity)


def test_a_textured_obj_is_scanned(tmp_path):
    mesh = body()
    Image.fromarray(np.array([[[255, 0, 0]], [[0, 0, 255]]], np.uint8)).save(tmp_path / "p.png")
    (tmp_path / "m.mtl").write_text("newmtl m\nmap_Kd p.png\n")
    v = np.clip((mesh.vertices[:, 1] + 1.5) / 3, 0, 1)
    lines = ["mtllib m.mtl", *("v {} {} {}".format(*p) for p in mesh.vertices)]
    lines += [*(f"vt 0.5 {0.25 if x < 0.5 else 0.75}" for x in v), "usemtl m"]
    lines += ["f {0}/{0} {1}/{1} {2}/{2}".format(*(face + 1)) for face in mesh.faces]
    (tmp_path / "t.obj").write_text("\n".join(lines))
    result = run("scan", tmp_path / "t.obj", "-o", tmp_path / "t.npz", *SMALL, *COLOURED)
    assert result.exit_code == 0, result.output
    found = Scan.load(tmp_path / "t.npz")
    edge = (
        2
        * np.linalg.norm(
            mesh.vertices[mesh.edges_unique[:, 0]] - mesh.vertices[mesh.edges_unique[:, 1]], axis=1
        ).max()
    )
    assert found.true_points[:, 1].min() > -edge  # a red laser sees no blue
    assert found.true_points[:, 1].max() > 1


def test_missing_colours_and_textures_are_one_line(tmp_path, mesh_file):
    out = tmp_path / "s.npz"
    fails(run("scan", mesh_file, "-o", out, *SMALL, *COLOURED), "no colours")
    (tmp_path / "m.mtl").write_text("newmtl m\nmap_Kd gone.png\n")
    (tmp_path / "t.obj").write_text(
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nusemtl m\n"
        "f 1/1 3/1 2/1\nf 1/1 2/1 4/1\nf 1/1 4/1 3/1\nf 2/1 3/1 4/1\n"
    )
    fails(run("scan", tmp_path / "t.obj", "-o", out, *SMALL, *COLOURED), "gone.png", "missing")
    assert not out.exists()

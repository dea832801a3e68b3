"""The report of a mesh, on meshes whose pieces, holes and handles are known."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from datasets_gen import load, write_mesh
from datasets_gen.collections.load_report import mesh_report
from datasets_gen.meshes.boundaries import boundary_loops
from tests.datasets_gen.collections.layout_files import egg
from tests.datasets_gen.sample_meshes import box, shape


def of(mesh):
    return shape(mesh.vertices, mesh.faces)


def test_loops_of_a_boundary():
    """A cube of twelve triangles without two that do not touch has two holes of three edges."""
    faces = box().faces
    apart = next(k for k in range(12) if not set(faces[k]) & set(faces[0]))
    assert boundary_loops(faces) == []
    assert sorted(boundary_loops(np.delete(faces, [0, apart], axis=0))) == [3, 3]


@pytest.mark.parametrize(
    ("mesh", "state"),
    [
        (of(trimesh.creation.icosphere(subdivisions=1)), "closed, one piece, genus 0, wound consistently"),
        (of(trimesh.creation.torus(2.0, 0.5)), "closed, one piece, genus 1, wound consistently"),
        (
            replace(box(), faces=box().faces[1:]),
            "open (1 hole, the longest rim of 3 edges), one piece, wound consistently",
        ),
        (replace(box(), faces=box().faces[:, ::-1]), "closed, one piece, genus 0, faces look inward"),
    ],
    ids=["sphere", "torus", "open box", "inward box"],
)
def test_pieces_holes_handles_and_winding(mesh, state):
    size, found = mesh_report(mesh)
    assert found == state
    assert size.startswith(f"{len(mesh.vertices):,} vertices, {len(mesh.faces):,} faces, diagonal ")


def test_what_is_wrong_is_counted():
    vertices, faces = egg()
    twice = np.concatenate([faces, faces[[3]], [[0, 0, 1]]])
    spoilt = shape(np.concatenate([vertices, vertices[[5]], [[9, 9, 9]]]), twice)
    told = mesh_report(spoilt)
    for words in (
        "1 faces repeat others",
        "1 faces name a vertex twice",
        "2 vertices belong to no face",
        "1 vertices lie where others do",
    ):
        assert words in told
    flipped = faces.copy()
    flipped[0] = flipped[0, ::-1]
    assert "3 edges have faces wound against each other" in mesh_report(shape(vertices, flipped))


def test_every_collection_keeps_one(tmp_path):
    torus = load("torus", poses=["round"])
    assert torus.remarks[1] == "torus/round: closed, one piece, genus 1, wound consistently"
    vertices, faces = egg()
    body = shape(np.concatenate([vertices, [[9, 9, 9]]]), faces[:, ::-1])
    for pose in ("rest", "bent"):
        write_mesh(replace(body, pose=pose), tmp_path / f"{pose}.ply")
    told = "\n".join(load(tmp_path).remarks)
    name = f"{tmp_path.name}/rest"
    assert f"{name}: 1 vertices belong to no face" in told
    assert f"{name}: faces turned round: closed, one piece, genus 0, wound consistently" in told
    told = "\n".join(load(tmp_path, repair=True).remarks)
    assert f"{name}: repaired: 162 vertices and 320 faces are kept" in told

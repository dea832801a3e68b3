import numpy as np
import pytest
import trimesh

from datasets_gen import InputError, as_shape, write_mesh
from datasets_gen.checks import signed_volume
from tests.datasets_gen.sample_meshes import shuffled, sphere

MESH = shuffled(sphere(2))


def test_every_kind_of_mesh_gives_the_same_shape(tmp_path):
    write_mesh(MESH, tmp_path / "ball.ply")
    kinds = {
        "pair": (MESH.vertices, MESH.faces),
        "lists": [MESH.vertices.tolist(), MESH.faces.tolist()],
        "trimesh": trimesh.Trimesh(MESH.vertices, MESH.faces, process=False),
        "path": tmp_path / "ball.ply",
        "text": str(tmp_path / "ball.ply"),
    }
    for kind, mesh in kinds.items():
        found = as_shape(mesh, name="given", units="mm")
        assert np.array_equal(found.faces, MESH.faces), kind
        assert found.vertices == pytest.approx(MESH.vertices, abs=1e-6), kind
        assert found.vertices.dtype == np.float64
        assert found.faces.dtype == np.int32
        assert found.name == ("ball" if kind in ("path", "text") else "given")
        assert found.units == "mm"


def test_a_sound_shape_is_returned_itself():
    assert as_shape(MESH) is MESH


def test_arrays_are_copied_and_inward_faces_turned():
    vertices = MESH.vertices.copy()
    found = as_shape((vertices, MESH.faces[:, ::-1]))
    vertices[:] = 0
    assert found.vertices == pytest.approx(MESH.vertices)
    assert np.array_equal(np.sort(found.faces), np.sort(MESH.faces))
    assert signed_volume(found.vertices, found.faces) == pytest.approx(4 / 3 * np.pi, rel=0.1)


@pytest.mark.parametrize(
    ("mesh", "reason"),
    [
        (3.5, "'float' is no mesh; give a Shape, the path"),
        (np.zeros((5, 3)), "'ndarray' is no mesh"),
        ((MESH.vertices, MESH.faces, MESH.faces), "'tuple' is no mesh"),
        ((MESH.vertices[:, :2], MESH.faces), "vertices must have shape"),
        ((MESH.vertices, MESH.faces.astype(float)), "whole numbers"),
        ((MESH.vertices, np.zeros((4, 4), int)), "cut polygons into triangles"),
        ((MESH.vertices, MESH.faces + len(MESH.vertices)), "faces name vertex"),
        ((MESH.vertices, [["a", "b", "c"]]), "whole numbers"),
        (([["a", "b", "c"]], MESH.faces), "array of numbers"),
        ((MESH.vertices, []), "no faces"),
        ((MESH.vertices * np.nan, MESH.faces), "NaN or infinite"),
        ("nowhere.ply", "does not exist"),
        (trimesh.Scene(trimesh.creation.box()), "scene"),
        (trimesh.PointCloud(MESH.vertices), "'PointCloud' is no mesh"),
    ],
)
def test_what_is_no_mesh_is_refused_in_one_line(mesh, reason):
    with pytest.raises(InputError, match=reason) as caught:
        as_shape(mesh)
    assert "\n" not in str(caught.value)

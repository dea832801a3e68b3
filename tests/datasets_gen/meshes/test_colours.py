"""Colours of files that other programs write, in the order in which the geometry is read."""

import numpy as np
import pytest
import trimesh
from PIL import Image

from datasets_gen import InputError
from datasets_gen.meshes.colours import Texture, colours_of, read_colours
from datasets_gen.meshes.files import read_mesh

QUAD = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
COORDINATES = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\n"


@pytest.fixture
def picture(tmp_path):
    """Red above blue."""
    Image.fromarray(np.array([[[255, 0, 0]], [[0, 0, 255]]], np.uint8)).save(tmp_path / "p.png")
    (tmp_path / "m.mtl").write_text("newmtl shiny\nKd 0.8 0.8 0.8\nmap_Kd p.png\nnewmtl green\nKd 0 1 0\n")
    return tmp_path / "p.png"


def ball(**colours):
    mesh = trimesh.creation.icosphere(subdivisions=1)
    rng = np.random.default_rng(0)
    if "vertex" in colours:
        mesh.visual.vertex_colors = rng.integers(0, 256, (len(mesh.vertices), 4), np.uint8)
    if "face" in colours:
        mesh.visual.face_colors = rng.integers(0, 256, (len(mesh.faces), 4), np.uint8)
    return mesh


@pytest.mark.parametrize("kind", ["vertex", "face"])
def test_ply_colours_as_trimesh_writes_them(tmp_path, kind):
    mesh = ball(**{kind: True})
    mesh.export(tmp_path / "a.ply")
    expected = getattr(mesh.visual, f"{kind}_colors")
    found = read_colours(tmp_path / "a.ply")
    assert list(found) == [f"{kind}_colour"]
    assert np.array_equal(found[f"{kind}_colour"], expected[:, :3])
    assert np.array_equal(colours_of(mesh)[f"{kind}_colour"], expected)


def test_ply_texture_by_vertex_and_by_corner(tmp_path, picture):
    head = "ply\nformat ascii 1.0\ncomment TextureFile p.png\nelement vertex 3\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    ends = "element face 2\nproperty list uchar int vertex_indices\n"
    by_vertex = head + "property float s\nproperty float t\n" + ends + "end_header\n"
    by_vertex += "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n3 2 1 0\n"
    by_corner = head + ends + "property list uchar float texcoord\nend_header\n"
    by_corner += "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 0 1\n3 2 1 0 6 0 1 1 0 0 0\n"
    for text in (by_vertex, by_corner):
        (tmp_path / "a.ply").write_text(text)
        texture = read_colours(tmp_path / "a.ply")["texture"]
        assert texture.uv.tolist() == [[[0, 0], [1, 0], [0, 1]], [[0, 1], [1, 0], [0, 0]]]
        assert texture.images[0][:, 0].tolist() == [[255, 0, 0], [0, 0, 255]]


def test_obj_texture_keeps_seams_and_the_cut_of_polygons(tmp_path, picture):
    """The vertices of the quad have other texture coordinates in the triangle."""
    faces = "usemtl shiny\nf 1/1 2/2 3/3 4/4\nusemtl green\nf 1/5 2/5 3/5\nusemtl shiny\nf -2/-1 -3/2 -4/1\n"
    (tmp_path / "a.obj").write_text("mtllib m.mtl\n" + QUAD + COORDINATES + faces)
    texture = read_colours(tmp_path / "a.obj")["texture"]
    shape = read_mesh(tmp_path / "a.obj")
    assert np.array_equal(texture.faces, shape.faces % 4)
    assert np.array_equal(texture.uv[:2], shape.vertices[shape.faces[:2]][..., :2])
    assert (texture.uv[2] == 0.5).all()
    assert texture.uv[3].tolist() == [[0.5, 0.5], [1, 0], [0, 0]]
    images = [texture.images[k] for k in texture.image_of_face]
    assert [image.shape for image in images] == [(2, 1, 3), (2, 1, 3), (1, 1, 3), (2, 1, 3)]
    assert images[2].ravel().tolist() == [0, 255, 0]


def test_obj_materials_without_an_image_need_no_coordinates(tmp_path, picture):
    (tmp_path / "a.obj").write_text("mtllib m.mtl\n" + QUAD + "f 1 2 3\nusemtl green\nf 1 3 4\n")
    texture = read_colours(tmp_path / "a.obj")["texture"]
    colours = [texture.images[k].ravel().tolist() for k in texture.image_of_face]
    assert colours == [[255, 255, 255], [0, 255, 0]]


def test_obj_vertex_colours(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0 1 0 0\nv 1 0 0 0 0.5 0\nv 0 1 0 0 0 1\nf 1 2 3\n")
    found = read_colours(tmp_path / "a.obj")["vertex_colour"]
    assert found.tolist() == [[1, 0, 0], [0, 0.5, 0], [0, 0, 1]]


@pytest.mark.parametrize(("one", "kind"), [("255", np.uint8), ("1.0", np.float64)])
def test_off_vertex_colours(tmp_path, one, kind):
    rows = f"0 0 0 {one} 0 0 {one}\n1 0 0 0 {one} 0 {one}\n0 1 0 0 0 {one} {one}\n"
    (tmp_path / "a.off").write_text(f"COFF\n# made by hand\n3 1 0\n{rows}3 0 1 2\n")
    found = read_colours(tmp_path / "a.off")["vertex_colour"]
    assert found.dtype == kind
    assert np.array_equal(found, float(one) * np.eye(3))
    assert len(read_mesh(tmp_path / "a.off").vertices) == 3


def test_textured_trimesh(picture):
    mesh = ball()
    uv = np.random.default_rng(0).random((len(mesh.vertices), 2))
    for material in (
        trimesh.visual.material.SimpleMaterial(image=Image.open(picture)),
        trimesh.visual.material.PBRMaterial(baseColorTexture=Image.open(picture)),
    ):
        mesh.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
        texture = colours_of(mesh)["texture"]
        assert np.allclose(texture.uv, uv[mesh.faces])
        assert texture.images[0].shape == (2, 1, 3)


def test_a_texture_follows_faces_that_are_wound_the_other_way():
    faces = np.array([[0, 1, 2], [3, 2, 1]])
    uv = np.random.default_rng(0).random((4, 2))
    texture = Texture.of_vertices(np.zeros((1, 1, 3), np.uint8), uv, faces)
    turned = np.array([[0, 2, 1], [1, 2, 3]])
    assert np.array_equal(texture.uv_in_order_of(turned), uv[turned])
    with pytest.raises(InputError, match="2 faces, but the mesh has 1"):
        texture.uv_in_order_of(turned[:1])


@pytest.mark.parametrize(
    ("files", "words"),
    [
        ({"a.obj": QUAD + "f 1 2 3\n"}, "no colours"),
        ({"a.off": "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"}, "no colours"),
        ({"a.obj": "mtllib n.mtl\nusemtl x\n" + QUAD + "f 1 2 3\n"}, "material file 'n.mtl'"),
        (
            {"a.obj": "mtllib n.mtl\nusemtl x\n" + QUAD + "f 1 2 3\n", "n.mtl": "newmtl x\nmap_Kd q.png\n"},
            "texture 'q.png' of .* is missing",
        ),
        (
            {"a.obj": "mtllib m.mtl\nusemtl shiny\n" + QUAD + "f 1 2 3\n"},
            "without texture coordinates",
        ),
        (
            {
                "a.obj": "mtllib n.mtl\nusemtl x\n" + QUAD + "f 1 2 3\n",
                "n.mtl": "newmtl x\nmap_Kd a.obj\n",
            },
            "no image",
        ),
        ({"a.ply": "ply\nformat ascii 1.0\nelement ver"}, "cannot be read"),
        ({}, "cannot be read"),
    ],
)
def test_missing_colours_are_one_line(tmp_path, picture, files, words):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=words) as caught:
        read_colours(tmp_path / next(iter(files), "none.ply"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("named", ["../secret.png", "{away}/secret.png", "link.png"])
def test_no_texture_outside_the_folder_of_its_mesh_is_read(tmp_path, picture, named):
    home = tmp_path / "home"
    home.mkdir()
    (tmp_path / "secret.png").write_bytes(picture.read_bytes())
    (home / "link.png").symlink_to(tmp_path / "secret.png")
    (home / "a.obj").write_text("mtllib n.mtl\nusemtl x\n" + QUAD + COORDINATES + "f 1/1 2/2 3/3\n")
    (home / "n.mtl").write_text(f"newmtl x\nmap_Kd {named.format(away=tmp_path)}\n")
    with pytest.raises(InputError, match=r"texture of 'a.obj', .* lies outside"):
        read_colours(home / "a.obj")
    (home / "a.obj").write_text("mtllib ../n.mtl\nusemtl x\n" + QUAD + "f 1 2 3\n")
    (tmp_path / "n.mtl").write_text("newmtl x\nKd 1 0 0\n")
    with pytest.raises(InputError, match=r"material file of 'a.obj', .* lies outside"):
        read_colours(home / "a.obj")

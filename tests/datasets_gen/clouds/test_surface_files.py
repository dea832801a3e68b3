"""Meshes and clouds in the formats of surfaces, each written by hand, and the values that they hold."""

import json
import struct

import numpy as np
import pytest

from datasets_gen import InputError
from datasets_gen.clouds.file_formats import read_points

POINTS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.5]]
NORMALS = [[0, 0, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]


def header(order, number="float", faces=True, more=()):
    lines = ["ply", f"format {order} 1.0", "comment caf\xe9", "element vertex 4"]
    lines += [f"property {number} {name}" for name in "xyz"]
    lines += ["element face 4", "property list uchar int vertex_indices"] if faces else []
    return "\n".join([*lines, *more, "end_header", ""]).encode("latin-1")


def binary(order, number="f"):
    sign = "<" if "little" in order else ">"
    body = b"".join(struct.pack(f"{sign}3{number}", *row) for row in POINTS)
    return body + b"".join(struct.pack(f"{sign}B3i", 3, *face) for face in FACES)


def read(folder, name, content):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_points(path)


def rows(table):
    return "".join(" ".join(map(str, row)) + "\n" for row in table)


@pytest.mark.parametrize("end", ["\n", "\r\n"], ids=["unix", "windows"])
def test_ply_in_text(tmp_path, end):
    text = header("ascii").decode("latin-1") + rows(POINTS) + rows([[3, *face] for face in FACES])
    found = read(tmp_path, "a.ply", text.replace("\n", end).encode("latin-1"))
    assert found.points.tolist() == POINTS
    assert found.faces.tolist() == FACES
    assert found.normals is None
    assert found.remarks == ()


@pytest.mark.parametrize("order", ["binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize(("word", "letter"), [("float", "f"), ("double", "d")])
def test_ply_in_binary(tmp_path, order, word, letter):
    found = read(tmp_path, "a.ply", header(order, word) + binary(order, letter))
    assert found.points.tolist() == POINTS
    assert found.faces.tolist() == FACES


def test_ply_with_bytes_after_its_end_is_read_with_a_remark(tmp_path):
    order = "binary_little_endian"
    found = read(tmp_path, "a.ply", header(order) + binary(order) + b"rest")
    assert found.faces.tolist() == FACES
    assert found.remarks == ("4 bytes after the last element are not used",)


def test_ply_cut_short_is_refused(tmp_path):
    order = "binary_little_endian"
    with pytest.raises(InputError, match=r"a\.ply' is cut short or no \.ply file"):
        read(tmp_path, "a.ply", header(order) + binary(order)[:-5])


def test_ply_with_lists_of_several_lengths(tmp_path):
    """A pentagon, a triangle and a quadrilateral, and a list beside the coordinates of each point."""
    more = ["element face 3", "property uchar flag", "property list uchar ushort vertex_index"]
    head = header("binary_big_endian", faces=False, more=more)
    head = head.replace(b"property float z", b"property list char short ids\nproperty float z")
    body = b"".join(struct.pack(">2fb", x, y, k) + struct.pack(f">{k}hf", *range(k), z)
                    for k, (x, y, z) in enumerate(POINTS))  # fmt: skip
    body += struct.pack(">BB5H", 7, 5, 0, 1, 2, 3, 0) + struct.pack(">BB3H", 7, 3, 1, 2, 3)
    body += struct.pack(">BB4H", 7, 4, 3, 2, 1, 0)
    found = read(tmp_path, "a.ply", head + body)
    assert found.points.tolist() == POINTS
    assert found.faces.tolist() == [[1, 2, 3], [3, 2, 1], [1, 0, 3], [0, 1, 2], [0, 2, 3], [0, 3, 0]]


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian"])
def test_ply_strips_of_triangles_have_one_winding(tmp_path, order):
    more = ["element tristrips 1", "property list int int vertex_indices"]
    strip = [0, 1, 2, 3, -1, 3, 2, 0]
    if order == "ascii":
        body = (rows(POINTS) + rows([[8, *strip]])).encode()
    else:
        body = b"".join(struct.pack("<3f", *row) for row in POINTS) + struct.pack("<9i", 8, *strip)
    found = read(tmp_path, "a.ply", header(order, faces=False, more=more) + body)
    assert found.faces.tolist() == [[0, 1, 2], [2, 1, 3], [3, 2, 0]]


def test_ply_normals_of_a_cloud(tmp_path):
    head = header("ascii", faces=False).decode("latin-1")
    names = "".join(f"property float n{axis}\n" for axis in "xyz") + "property uchar red\n"
    head = head.replace("end_header", names + "end_header")
    table = [[*p, *n, 200] for p, n in zip(POINTS, NORMALS, strict=True)]
    found = read(tmp_path, "a.ply", (head + rows(table)).encode("latin-1"))
    assert found.points.tolist() == POINTS
    assert found.normals.tolist() == NORMALS
    assert not found.is_mesh


def test_obj_with_quads_normals_and_negative_indices(tmp_path):
    text = "mtllib a.mtl\n" + "".join(f"v {x} {y} {z} 0.5 0.5 1\n" for x, y, z in POINTS)
    text += "vn 0 0 1\nusemtl skin\nf 1//1 3//1 2//1\nf -4 -3 -1\no other\nf 1//1 2//1 3//1 4//1\n"
    found = read(tmp_path, "a.obj", text)
    assert found.points.tolist() == POINTS
    assert found.faces.tolist() == [[0, 2, 1], [0, 1, 3], [0, 1, 2], [2, 3, 0]]


def test_obj_of_points_alone(tmp_path):
    both = "".join(f"v {x} {y} {z}\nvn {a} {b} {c}\n"
                   for (x, y, z), (a, b, c) in zip(POINTS, NORMALS, strict=True))  # fmt: skip
    found = read(tmp_path, "a.obj", both)
    assert found.normals.tolist() == NORMALS
    fewer = read(tmp_path, "a.obj", both.replace("vn 0 0 1\n", ""))
    assert fewer.normals is None
    assert fewer.remarks == ("3 normals for 4 points: not used",)


@pytest.mark.parametrize("one_line", [True, False], ids=["header-on-one-line", "header-on-two"])
@pytest.mark.parametrize(
    ("kind", "before", "after"),
    [
        ("OFF", [], []),
        ("NOFF", [[0, 0, 1]], []),
        ("COFF", [], [[255, 0, 0, 255]]),
        ("CNOFF", [[0, 0, 1]], [[0.5, 0, 0, 1]]),
        ("STOFF", [], [[0.25, 0.75]]),
        ("STCNOFF", [[0, 0, 1]], [[0.5, 0, 0, 1], [0.25, 0.75]]),
    ],
)
def test_off_of_every_kind(tmp_path, kind, before, after, one_line):
    extra = [value for part in after for value in part]
    text = f"# by hand\n{kind}{' ' if one_line else chr(10)}4 4 6 # counts\n\n"
    text += rows([[*p, *(before[0] if before else []), *extra] for p in POINTS])
    text += rows([[3, *face, 0.1, 0.2, 0.3] for face in FACES])
    found = read(tmp_path, "a.off", text)
    assert found.points.tolist() == POINTS
    assert found.faces.tolist() == FACES
    assert (found.normals is not None) == bool(before)
    assert found.normals is None or found.normals.tolist() == 4 * before


def test_off_of_points_with_normals(tmp_path):
    table = [[*p, *n] for p, n in zip(POINTS, NORMALS, strict=True)]
    found = read(tmp_path, "a.off", "NOFF\n4 0 0\n" + rows(table))
    assert found.normals.tolist() == NORMALS
    with pytest.raises(InputError, match="line 4: 5 numbers where six are needed"):
        read(tmp_path, "a.off", "NOFF\n4 0 0\n" + rows(table).replace("1 0 0 1 0 0", "1 0 0 1 0"))


def stl_text():
    facets = "".join(
        "facet normal 0 0 0\n outer loop\n"
        + "".join(f"  vertex {x} {y} {z}\n" for x, y, z in (POINTS[k] for k in face))
        + " endloop\nendfacet\n"
        for face in FACES
    )
    return f"solid by hand\n{facets}endsolid by hand\n"


def stl_binary():
    corners = [[value for k in face for value in POINTS[k]] for face in FACES]
    return b"solid, yet binary".ljust(80) + struct.pack("<I", 4) + b"".join(
        struct.pack("<12fH", 0, 0, 0, *row, 0) for row in corners
    )  # fmt: skip


@pytest.mark.parametrize("content", [stl_text(), stl_binary()], ids=["text", "binary"])
def test_stl_corners_are_welded(tmp_path, content):
    found = read(tmp_path, "a.stl", content)
    assert len(found) == 4
    assert found.points[found.faces].tolist() == [[POINTS[k] for k in face] for face in FACES]
    assert found.remarks == ("STL repeats the corners of each face: 12 welded to 4 vertices",)


def test_stl_with_bytes_too_many_or_too_few(tmp_path):
    assert (
        "3 bytes after the last facet are not used" in read(tmp_path, "a.stl", stl_binary() + b"abc").remarks
    )
    with pytest.raises(InputError, match="0 bytes: no facets in text"):
        read(tmp_path, "a.stl", b"")
    with pytest.raises(InputError, match="3 facets where 4 should be"):
        read(tmp_path, "a.stl", stl_binary()[:-10])
    with pytest.raises(InputError, match="11 corners for 4 facets"):
        read(tmp_path, "a.stl", stl_text().replace("  vertex 0 0 1.5\n", "", 1))


def gltf():
    """Two nodes with one triangle, the second one moved; the triangle's corners repeat a place."""
    corners = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0)
    ids = struct.pack("<6H", 0, 1, 2, 3, 2, 1)
    return corners + ids, {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"mesh": 0, "translation": [0, 0, 5]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": 4,
                "type": "VEC3",
                "min": [0, 0, 0],
                "max": [1, 1, 0],
            },
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12},
        ],
    }


@pytest.mark.parametrize("suffix", ["glb", "gltf"])
def test_gltf_meshes_stand_where_their_nodes_put_them(tmp_path, suffix):
    data, tree = gltf()
    if suffix == "gltf":
        (tmp_path / "a.bin").write_bytes(data)
        content = json.dumps(tree | {"buffers": [{"uri": "a.bin", "byteLength": len(data)}]}).encode()
    else:
        text = json.dumps(tree | {"buffers": [{"byteLength": len(data)}]}).encode()
        text += b" " * (-len(text) % 4)
        chunks = (
            struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x4E4942) + data
        )
        content = struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks
    found = read(tmp_path, f"a.{suffix}", content)
    triangle = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    expected = np.concatenate([triangle, triangle + np.array([0, 0, 5])])
    assert sorted(found.points.tolist()) == sorted(expected.tolist())
    assert len(found.faces) == 4
    assert "2 meshes of the scene are one" in found.remarks
    assert "glTF repeats vertices at seams: 8 welded to 6 vertices" in found.remarks


def test_gltf_takes_no_buffer_from_another_folder(tmp_path):
    data, tree = gltf()
    (tmp_path / "home").mkdir()
    (tmp_path / "a.bin").write_bytes(data)
    content = json.dumps(tree | {"buffers": [{"uri": "../a.bin", "byteLength": len(data)}]})
    with pytest.raises(InputError, match="outside"):
        read(tmp_path / "home", "a.gltf", content)


def test_files_that_are_not_read_or_not_there(tmp_path):
    with pytest.raises(InputError, match=r"a\.3ds' is no cloud or mesh file this project reads; it reads"):
        read(tmp_path, "a.3ds", b"")
    with pytest.raises(InputError, match="does not exist"):
        read_points(tmp_path / "none.ply")

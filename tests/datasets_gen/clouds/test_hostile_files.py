"""Files that were read wrongly in silence, or refused for a wrong reason: each as a program writes it."""

import numpy as np
import pytest

from datasets_gen import InputError
from datasets_gen.clouds.file_formats import read_points

POINTS = [[0.0, 0.5, 1.5], [1.0, 0.25, 0.0], [2.5, 1.0, 0.75], [-1.0, 0.0, 4.0]]
UNIT = [[0, 0, -1], [0.6, 0.8, 0], [0, -0.8, 0.6], [0, 1, 0]]
VERTICES = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
)
PCD = (
    "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n"
)
FACET = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
STL = f"solid a\n{FACET}endsolid a\n"


def read(folder, name, content, columns=None):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_points(path, columns)


def text(*tables, separator=" "):
    rows = np.column_stack(tables)
    return "".join(separator.join(f"{value:g}" for value in row) + "\n" for row in rows)


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("more", [(), (UNIT,)], ids=["four", "seven"])
def test_a_first_column_that_numbers_the_rows_is_no_coordinate(tmp_path, first, more):
    content = text(np.arange(first, first + 4), POINTS, *more)
    with pytest.raises(InputError, match=rf"line 1: the first of .* counts the rows from {first}.*--columns"):
        read(tmp_path, "a.txt", content)
    names = "- x y z" + (" nx ny nz" if more else "")
    assert read(tmp_path, "a.txt", content, names).points.tolist() == POINTS


def test_an_empty_cell_is_refused_with_its_line(tmp_path):
    """The cells after it would move one column: here into a row of the same width as the others."""
    content = "1.0,2.0,,3.0,0.5\n1.0,,2.0,3.0,0.5\n"
    with pytest.raises(InputError, match=r"line 1, has an empty cell.*write nan"):
        read(tmp_path, "a.csv", content)
    trailing = read(tmp_path, "b.csv", "1.0,2.0,3.0,\n4.0,5.0,6.0,\n")
    assert trailing.points.tolist() == [[1, 2, 3], [4, 5, 6]]


OBJ = {
    "blanks-first": VERTICES.replace("v", "  v") + "  f 1 2 3\n",
    "tabs": VERTICES.replace(" ", "\t") + "f\t1\t2\t3\n",
    "comment-after": VERTICES + "f 1 2 3 # first\n",
    "latin-1": "# Größe\n".encode("latin-1") + (VERTICES + "f 1/1 2/1 3/1\n").encode(),
    "cr": (VERTICES + "f 1 2 3\n").replace("\n", "\r"),
    "goes-on": VERTICES + "f 1 2 \\\n3\n",
}


@pytest.mark.parametrize("name", OBJ)
def test_obj_lines_of_every_form(tmp_path, name):
    found = read(tmp_path, "a.obj", OBJ[name])
    assert found.points.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert found.faces.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize(
    ("face", "said"),
    [("f 0 1 2", "line 4: vertex 0 of 3"), ("f -4 -2 -1", "line 4: vertex -4"), ("f 1 2 4", "vertex 4 of 3")],
    ids=["counted-from-0", "before-the-first", "after-the-last"],
)
def test_obj_faces_never_wrap_round(tmp_path, face, said):
    with pytest.raises(InputError, match=said):
        read(tmp_path, "a.obj", VERTICES + face + "\n")


def test_obj_negative_indices_count_from_the_face(tmp_path):
    with pytest.raises(InputError, match="line 3: vertex -3, counted backwards from 2"):
        read(tmp_path, "a.obj", "v 0 0 0\nv 1 0 0\nf -3 -2 -1\nv 0 1 0\n")


@pytest.mark.parametrize("form", ["cr", "bom", "upper", "comment"])
def test_ply_in_text_of_every_form(tmp_path, form):
    content = {
        "cr": PLY.replace("\n", "\r"),
        "bom": "\ufeff" + PLY,
        "upper": PLY.replace("ply\n", "PLY\n", 1),
        "comment": PLY.replace("element vertex", "comment end_header is below\nelement vertex"),
    }[form]
    assert read(tmp_path, "a.ply", content).faces.tolist() == [[0, 1, 2]]


SECOND = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("float z\n", "float z\nproperty float x\n", "names 'x' of 'vertex' twice"),
        ("element face", SECOND + "element face", "two elements 'vertex'"),
        ("vertex 3", "vertex -3", "line 3: -3 where a count"),
    ],
    ids=["property-twice", "element-twice", "negative-count"],
)
def test_ply_header_that_says_two_things_is_refused(tmp_path, old, new, said):
    content = PLY.replace(old, new, 1)
    if new.endswith("x\n"):
        content = content.replace("\n0 0 0\n1 0 0\n0 1 0\n", "\n0 0 0 5\n1 0 0 5\n0 1 0 5\n")
    elif new.startswith(SECOND):
        content = content.replace("\n3 0 1 2", "\n7 7 7\n3 0 1 2")
    with pytest.raises(InputError, match=said):
        read(tmp_path, "a.ply", content)


def test_ply_in_binary_cut_short_says_where(tmp_path):
    head = PLY.partition("end_header")[0].replace("ascii", "binary_little_endian") + "end_header\n"
    body = np.zeros((3, 3), "<f4").tobytes() + b"\3" + np.arange(3, dtype="<i4").tobytes()
    assert read(tmp_path, "a.ply", head.encode() + body).faces.tolist() == [[0, 1, 2]]
    with pytest.raises(InputError, match="a list of 3 numbers, beyond the end of the file"):
        read(tmp_path, "a.ply", head.encode() + body[:-2])


@pytest.mark.parametrize(
    "content",
    [STL.replace("\n", "\r"), STL.upper(), STL.replace("solid a", "solid " + "n" * 5000)],
    ids=["cr", "upper", "long-name"],
)
def test_stl_in_text_of_every_form(tmp_path, content):
    assert read(tmp_path, "a.stl", content).points.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize("word", ["0,5", "nan", "abc"])
def test_stl_in_text_says_the_line_of_a_word_that_is_no_number(tmp_path, word):
    with pytest.raises(InputError, match=f"line 5: '{word}'"):
        read(tmp_path, "a.stl", STL.replace("vertex 1", f"vertex {word}"))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (PCD + "1 2 3\n1 0,5 3\n", "line 11: '0,5'"),
        (PCD + "1 2 3\n1 2\n", "line 11: 2 numbers where 3"),
        (PCD + "1 2 3 4\n1 2 3 4\n", "line 10: 4 numbers where 3"),
        (PCD.replace("WIDTH 2", "WIDTH 1") + "1 2 3\n1 2 3\n", "POINTS 2, but WIDTH x HEIGHT is 1"),
        (PCD.replace("x y z", "x y x") + "1 2 3\n1 2 3\n", "FIELDS names 'x' twice"),
    ],
    ids=["decimal-comma", "short", "long", "size", "field-twice"],
)
def test_pcd_in_text_says_what_is_wrong_where(tmp_path, content, said):
    with pytest.raises(InputError, match=said):
        read(tmp_path, "a.pcd", content)


@pytest.mark.parametrize(
    ("array", "said"),
    [
        (np.zeros((3, 400)), r"transpose it to \(n, 3\)"),
        (np.zeros((4, 3), bool), "holds bool"),
        (np.zeros((4, 3), "M8[s]"), "holds datetime64"),
    ],
    ids=["transposed", "bool", "dates"],
)
def test_npy_of_something_else_is_refused(tmp_path, array, said):
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(InputError, match=said):
        read_points(tmp_path / "a.npy")

"""Files in text that are wrong somewhere: the message names the file and the line."""

import numpy as np
import pytest
import trimesh

from datasets_gen import InputError, load_mesh
from datasets_gen.meshes.bad_lines import bad_line

CORNERS = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"]
FACES = ["3 0 2 1", "3 0 1 3", "3 0 3 2", "3 1 2 3"]
HEADER = [
    *("ply", "format ascii 1.0", "comment by hand", "element vertex 4"),
    *(f"property float {axis}" for axis in "xyz"),
    *("element face 4", "property list uchar int vertex_indices", "end_header"),
]
PLY = [*HEADER, *CORNERS, *FACES]
OFF = ["OFF", "# by hand", "4 4 6", "", *CORNERS, *FACES]
OBJ = [*(f"v {c}" for c in CORNERS), "", "f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]
WHOLE = {"ply": PLY, "off": OFF, "obj": OBJ}


def written(folder, suffix, lines, end="\n"):
    path = folder / f"mesh.{suffix}"
    path.write_bytes(end.join([*lines, ""]).encode())
    return path


@pytest.mark.parametrize("suffix", WHOLE)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_whole_files_have_no_bad_line(tmp_path, suffix, end):
    path = written(tmp_path, suffix, WHOLE[suffix], end)
    assert bad_line(path) == bad_line(path, thorough=False) == ""
    assert len(load_mesh(path).faces) == 4


@pytest.mark.parametrize(
    ("suffix", "number", "line", "said"),
    [
        ("ply", 4, "element vertex four", "'four' where a count should be"),
        ("ply", 6, "property flot y", "'flot' is no type of number"),
        ("ply", 10, "end_of_header", "no line of a header"),
        ("ply", 13, "0 oops 0", "'oops' where a number should be"),
        ("ply", 13, "0 1", "2 numbers where 3 are needed"),
        ("ply", 13, "0 nan 0", "NaN or infinite"),
        ("ply", 16, "3 0 x 3", "'x' where a vertex should be"),
        ("ply", 16, "3 0 1", "3 numbers where 4 are needed"),
        ("ply", 16, "3 0 1 9", "vertex 9 of 4, counted from 0"),
        ("ply", 16, "3 0 1 -1", "vertex -1 of 4, counted from 0"),
        ("off", 1, "ON", "does not begin with OFF"),
        ("off", 3, "4 four 6", "'four' where a count should be"),
        ("off", 7, "0 oops 0", "'oops' where a number should be"),
        ("off", 7, "0 1", "2 numbers where three are needed"),
        ("off", 7, "0 inf 0", "NaN or infinite"),
        ("off", 10, "3 0 x 3", "'x' where a vertex should be"),
        ("off", 10, "3 0 1", "3 numbers where 4 are needed"),
        ("off", 10, "3 0 1 9", "vertex 9 of 4, counted from 0"),
        ("obj", 3, "v 0 oops 0", "'oops' where a number should be"),
        ("obj", 3, "v 0 1", "2 numbers where three are needed"),
        ("obj", 3, "v 0 nan 0", "NaN or infinite"),
        ("obj", 7, "f 1 2 9", "vertex 9 of 4, counted from 1"),
    ],
)
def test_meshes_are_refused_with_file_and_line(tmp_path, suffix, number, line, said):
    lines = list(WHOLE[suffix])
    lines[number - 1] = line
    path = written(tmp_path, suffix, lines)
    with pytest.raises(InputError) as caught:
        load_mesh(path)
    for words in (repr(str(path)), f"line {number}", said):
        assert words in str(caught.value)


@pytest.mark.parametrize(("suffix", "last"), [("ply", 12), ("ply", 15), ("off", 6), ("off", 9)])
def test_a_file_that_is_cut_short_is_refused_with_its_last_line(tmp_path, suffix, last):
    """Parsers read the faces that are left, as if that were all."""
    path = written(tmp_path, suffix, WHOLE[suffix][:last])
    with pytest.raises(InputError, match=rf"mesh.{suffix}.*line {last} is the last: \d rows of kind"):
        load_mesh(path)


def test_a_header_without_an_axis(tmp_path):
    path = written(tmp_path, "ply", [line for line in PLY if line != "property float z"])
    with pytest.raises(InputError, match="names no property 'z' of vertices"):
        load_mesh(path)


def test_binary_files_have_no_lines(tmp_path):
    path = tmp_path / "ball.ply"
    trimesh.creation.icosphere(subdivisions=1).export(path)
    assert bad_line(path) == ""
    path.write_bytes(path.read_bytes()[:-40])
    assert bad_line(path) == ""
    with pytest.raises(InputError, match="cut short or no"):
        load_mesh(path)


def test_colours_and_further_elements_are_no_faults(tmp_path):
    coloured = ["COFF", "4 1 0", *(f"{c} 255 0 0 255" for c in CORNERS), "4 0 1 2 3 0.5 0.5 0.5"]
    assert bad_line(written(tmp_path, "off", coloured)) == ""
    head = [*HEADER[:-1], "element edge 1", "property int vertex1", "property int vertex2", "end_header"]
    assert bad_line(written(tmp_path, "ply", [*head, *CORNERS, *FACES, "0 1"])) == ""
    assert "line 22" in bad_line(written(tmp_path, "ply", [*head, *CORNERS, *FACES, "0"]))


def test_counts_on_the_first_line_of_an_off(tmp_path):
    path = written(tmp_path, "off", ["OFF 4 4 6", *CORNERS, *FACES])
    assert bad_line(path) == ""
    assert np.array_equal(load_mesh(path).faces[0], [0, 2, 1])

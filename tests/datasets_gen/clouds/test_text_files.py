"""Texts of numbers: each kind by hand with what it holds, and each that can be read in two ways refused."""

import numpy as np
import pytest

from datasets_gen import InputError
from datasets_gen.clouds.file_formats import read_points

POINTS = [[0, 0.5, 1.5], [1, 0.25, 0], [2.5, 1, 0.75], [-1, 0, 4]]
UNIT = [[0, 0, -1], [0.6, 0.8, 0], [0, -0.8, 0.6], [0, 1, 0]]
BYTES = [[255, 0, 12], [1, 2, 3], [200, 100, 50], [0, 0, 0]]
COLOURS = "columns 4 to 6 are colours, not normals, and not used"


def lines(*tables, separator=" ", comma=False):
    text = "\n".join(
        separator.join(f"{value:g}" for table in tables for value in table[k]) for k in range(len(POINTS))
    )
    return (text.replace(".", ",") if comma else text) + "\n"


def read(folder, content, name="a.txt", columns=None):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_points(path, columns)


@pytest.mark.parametrize("name", ["a.xyz", "a.txt", "a.pts", "a.csv", "a.asc", "A.XYZ"])
@pytest.mark.parametrize("separator", [" ", "\t", ",", ", ", ";", "; "])
def test_three_columns_are_points(tmp_path, name, separator):
    found = read(tmp_path, lines(POINTS, separator=separator), name)
    assert found.points.tolist() == POINTS
    assert found.normals is None
    assert found.remarks == ()


INTENSITY = [[0.5], [0.25], [1], [7]]
CASES = {
    "unit-length": (lines(POINTS, UNIT), UNIT, ""),
    "bytes": (lines(POINTS, BYTES), None, COLOURS),
    "shares": (lines(POINTS, np.divide(BYTES, 255)), None, COLOURS),
    "four": (lines(POINTS, INTENSITY), None, "the fourth column is taken for an intensity"),
    "seven": (lines(POINTS, INTENSITY, BYTES), None, "columns 4 to 7, intensity and colours"),
    "seven-with-normals": (lines(POINTS, INTENSITY, UNIT), UNIT, "columns 5 to 7 are taken for normals"),
    "nine": (lines(POINTS, BYTES, UNIT), UNIT, "columns 4 to 6 are colours"),
    "nine-normals-first": (lines(POINTS, UNIT, BYTES), UNIT, "columns 7 to 9 are colours"),
}


@pytest.mark.parametrize("name", CASES)
def test_columns_without_names_are_told_by_what_is_in_them(tmp_path, name):
    text, normals, said = CASES[name]
    found = read(tmp_path, text)
    assert found.points.tolist() == POINTS
    assert (found.normals is None and normals is None) or found.normals.tolist() == normals
    assert said in " ".join(found.remarks)


def test_normals_that_are_rounded_or_lacking_are_normals(tmp_path):
    """Two decimals; and one row in ten without a direction, as some programs write it."""
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(50, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals[::10] = 0
    np.savetxt(tmp_path / "a.xyz", np.hstack([rng.normal(size=(50, 3)), normals]), fmt="%.2f")
    assert np.allclose(read_points(tmp_path / "a.xyz").normals, normals, atol=0.005)


@pytest.mark.parametrize(
    "head",
    [
        "r g b x y z nx ny nz",
        "# r g b x y z nx ny nz\n# made by hand",
        "//R G B X Y Z Nx Ny Nz",
        '"red" "green" "blue" "Points:0" "Points:1" "Points:2" "Normals:0" "Normals:1" "Normals:2"',
        "Rf\tGf\tBf\tX [m]\tY [m]\tZ [m]\tnormal_x\tnormal_y\tnormal_z",
    ],
    ids=["names", "comment", "cloudcompare", "paraview", "units"],
)
def test_names_decide(tmp_path, head):
    if head.startswith(("#", "//")):
        columns = (POINTS, UNIT, BYTES)
        head = head.replace("r g b x y z nx ny nz", "x y z nx ny nz r g b")
        head = head.replace("R G B X Y Z Nx Ny Nz", "X Y Z Nx Ny Nz R G B")
    else:
        columns = (BYTES, POINTS, UNIT)
    found = read(tmp_path, f"{head}\n{lines(*columns)}")
    assert found.points.tolist() == POINTS
    assert found.normals.tolist() == UNIT
    assert found.remarks == ("columns that are not used (by the file's names): r, g, b",)


def test_colours_that_are_called_so_are_never_normals(tmp_path):
    found = read(tmp_path, "x,y,z,r,g,b\n" + lines(POINTS, UNIT, separator=","), "a.csv")
    assert found.normals is None


def test_names_on_the_command_line_come_first(tmp_path):
    text = lines(UNIT, INTENSITY, POINTS)
    found = read(tmp_path, text, columns="nx ny nz - x y z")
    assert found.points.tolist() == POINTS
    assert found.normals.tolist() == UNIT
    with pytest.raises(InputError, match="line 1, has 7 columns, but 6 are named"):
        read(tmp_path, text, columns="x y z nx ny nz")
    with pytest.raises(InputError, match="'a b c' do not name x, y and z"):
        read(tmp_path, text, columns="a b c")
    with pytest.raises(InputError, match=r"not for \.ply"):
        read(tmp_path, b"", "a.ply", columns="x y z")


@pytest.mark.parametrize(
    "content",
    [
        b"\xef\xbb\xbf" + lines(POINTS).encode(),
        b"# caf\xe9, \xb5m\n" + lines(POINTS).encode(),
        ("\ufeff" + lines(POINTS)).encode("utf-16-le"),
        lines(POINTS).replace("\n", "\r\n").encode(),
        lines(POINTS).replace("\n", "\r").encode(),
        b"4\n" + lines(POINTS).encode(),
        b"2\n" + lines(POINTS).replace("\n2.5", "\n2\n2.5").encode(),
        b"% by hand\n\n" + lines(POINTS).encode() + b"\n// end\n",
    ],
    ids=["bom", "latin-1", "utf-16", "windows", "old-mac", "count", "two-counts", "comments"],
)
def test_what_stands_around_the_numbers_is_understood(tmp_path, content):
    assert read(tmp_path, content, "a.pts").points.tolist() == POINTS


@pytest.mark.parametrize("separator", [" ", ";", "; ", "\t"])
@pytest.mark.parametrize("head", ["", "x;y;z\n"], ids=["bare", "named"])
def test_decimal_commas_are_read_as_points(tmp_path, separator, head):
    found = read(tmp_path, head + lines(POINTS, separator=separator, comma=True))
    assert found.points.tolist() == POINTS
    assert found.remarks == ("decimal commas are read as points",)


def test_a_comma_between_numbers_with_points_separates(tmp_path):
    assert read(tmp_path, "0,1 0.5\n2,3 0.25\n").points.tolist() == [[0, 1, 0.5], [2, 3, 0.25]]
    assert read(tmp_path, "1,2,3\n4,5,6\n").points.tolist() == [[1, 2, 3], [4, 5, 6]]


REFUSED = {
    "two-ways": ("1,5,2,5,3,5\n", "line 1, can be read in two ways: '1,5,2,5,3,5' is 6 whole numbers or 3"),
    "both-signs": (
        "1.5;2;3\n1,5;2;3\n",
        "line 2, has commas within semicolons where other numbers have points",
    ),
    "five": (
        "# by hand\n1 2 3 4 5\n",
        "line 2, has 5 columns, which can mean several things; name the columns",
    ),
    "two": ("1 2\n", "line 1, has 2 columns"),
    "neither": ("1 2 3 0 0 1\n1 2 3 0 5.5 1\n", "line 2: columns 4 to 6 (0 5.5 1) are neither normals"),
    "nine": ("1 2 3 4 5.5 6 7 8.5 9\n", "line 1, has 9 columns"),
    "nine-both": ("1 2 3 0 0 1 0 1 0\n", "line 1, has 9 columns"),
    "ragged": ("0 0 0\n1 2 3\n4 5\n", "line 3, has 2 columns, the first line 3; give as many in each"),
    "word": ("0 0 0\n1 x 3\n", "line 2, is no row of numbers"),
    "underscore": ("0 0 0\n1_0 2 3\n", "line 2, is no row of numbers ('1_0')"),
    "names": ("a b c\n1 2 3\n", "names the columns 'a b c', none of them x; name the columns"),
    "no-z": ("x y intensity\n1 2 3\n", "none of them z"),
    "twice": ("x y z x\n1 2 3 4\n", "names two columns x"),
    "more-names": ("x y z nx ny nz\n1 2 3\n", "line 2, has 3 columns, but 6 are named; give a name for each"),
    "short-count": ("5\n1 2 3\n", "line 1, says 5 rows, but 1 follow; the file is cut short"),
    "long-count": ("1\n1 2 3\n4 5 6\n", "line 3, is one row more than the number of rows before it says"),
    "binary": (b"1 2 3\n4 \0 6\n", "line 2, is no text (byte 8); give columns of numbers"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_understood_is_refused_with_the_line(tmp_path, name):
    content, said = REFUSED[name]
    with pytest.raises(InputError) as caught:
        read(tmp_path, content)
    assert said in str(caught.value)
    assert "a.txt'" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_whole_numbers_with_names_are_not_decimal_commas(tmp_path):
    found = read(tmp_path, "x,y,z,r,g,b\n1,5,2,5,3,5\n", "a.csv")
    assert found.points.tolist() == [[1, 5, 2]]

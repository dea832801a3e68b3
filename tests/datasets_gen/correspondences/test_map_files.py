"""Correspondence files, written here by hand as the sources of each format describe them."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from datasets_gen import InputError
from datasets_gen.correspondences.point_map import PointMap
from datasets_gen.correspondences.reading import read_map
from datasets_gen.correspondences.writing import WRITTEN, write_map


def written(path: Path, text: str | bytes) -> Path:
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    ("name", "text", "ids"),
    [
        ("a.vts", "3\n1\n2\n", [2, 0, 1]),  # remeshed sets count from 1
        ("a.vts", "3\r\n1\r\n2", [2, 0, 1]),
        ("a.map", "2\n0\n1\n", [2, 0, 1]),  # PFARM counts from 0
        ("a.map", "2\n-1\n1\n", [2, -1, 1]),
        ("a.txt", "# first_id = 1\n3 0.5\n1 1\n", [2, 0]),
        ("a.txt", "% first_id = 0\n3\nNaN\n", [3, -1]),
        ("a.txt", b"\xef\xbb\xbf# first_id = 0\n2.0\n1e0\n", [2, 1]),
        ("a.csv", "# first_id = 0\nsource,target,confidence\n0,5,.5\n1,-1,0\n", [5, -1]),
    ],
)
def test_what_a_file_says(tmp_path, name, text, ids):
    assert read_map(written(tmp_path / name, text)).ids.tolist() == ids


def test_triangles_with_weights(tmp_path):
    """SHREC'16: triangles count from 1; ``-1 0 0 0`` is no match."""
    for name in ("a.corr", "cuts_cat_shape_1.baryc_gt"):
        found = read_map(written(tmp_path / name, "1 0.25 0.25 0.5\n-1 0 0 0\n7 1 0 0\n"))
        assert found.ids.tolist() == [0, -1, 6]
        assert found.weights.tolist() == [[0.25, 0.25, 0.5], [0, 0, 0], [1, 0, 0]]


def test_matlab_counts_from_one_unless_it_says_otherwise(tmp_path):
    savemat(tmp_path / "a.mat", {"matches": np.array([[3.0], [1.0], [np.nan]])})
    assert read_map(tmp_path / "a.mat").ids.tolist() == [2, 0, -1]
    savemat(tmp_path / "b.mat", {"p2p": np.array([[3, 0]]), "first_id": 0})
    assert read_map(tmp_path / "b.mat").ids.tolist() == [3, 0]
    savemat(tmp_path / "c.mat", {"F": np.eye(2)})
    with pytest.raises(InputError, match="there are F"):
        read_map(tmp_path / "c.mat")


@pytest.mark.parametrize("suffix", [s for s in WRITTEN if s != ".corr"])
def test_what_is_written_is_read(tmp_path, suffix):
    given = PointMap(np.array([4, -1, 0, 2]), confidence=np.array([1, 0, 0.25, 0.5]))
    write_map(given, tmp_path / f"a{suffix}", names=("a #1", "b\nc"), first_id=1)
    found = read_map(tmp_path / f"a{suffix}")
    assert found.ids.tolist() == [4, -1, 0, 2]
    if suffix not in (".map", ".vts"):
        assert np.allclose(found.confidence, given.confidence)


def test_triangles_are_written_as_they_are_read(tmp_path):
    given = PointMap(np.array([6, -1]), np.array([[0.5, 0.25, 0.25], [0, 0, 0]]))
    write_map(given, tmp_path / "a.corr")
    assert (tmp_path / "a.corr").read_text().splitlines() == ["7 0.5 0.25 0.25", "-1 0 0 0"]
    with pytest.raises(InputError, match=r"write \.corr"):
        write_map(given, tmp_path / "a.txt")


def test_a_matlab_file_counts_from_one_and_says_so(tmp_path):
    write_map(PointMap(np.array([0, -1])), tmp_path / "a.mat", names=("cat0", "cat1"))
    data = loadmat(tmp_path / "a.mat")
    assert data["source_to_target"].ravel().tolist() == [1, -1]
    assert "of cat1 for point i of cat0" in str(data["direction"])


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.txt", "3\n1\n", "does not say whether indices count from 0 or 1"),
        ("a.txt", "# first_id = 0\n1\n1.5\n", "entry 2 is 1.5, no index"),
        ("a.txt", "# first_id = 0\n1\n-7\n", "entry 2 is -7"),
        ("a.txt", "# first_id = 0\n1\ntwo\n", "line 3: 'two' is no number"),
        ("a.txt", "# first_id = 0\n1 1\n1\n", "line 3, has 1 columns, line 2 2"),
        ("a.txt", "# first_id = 0\n1 2\n1 1\n", "confidence of entry 1 is 2; it must lie in"),
        ("a.vts", "1 2 3\n", "3 columns without names"),
        ("a.corr", "1 2 3\n", "3 columns; give a triangle and three weights"),
        ("a.corr", "1 .5 .5 .5\n", "row 1 are no barycentric coordinates"),
        ("a.csv", "source,match2\n0,1\n", "no column is called target"),
        ("a.csv", "# first_id = 0\nsource,target\n4,1\n2,1\n", "does not count all points in order"),
        ("a.npz", "nonsense", "not a readable correspondence"),
        ("a.mat", "nonsense", "no MATLAB file of level 5"),
        ("a.dat", "1\n", "no correspondence file"),
    ],
)
def test_what_is_wrong_is_said_with_the_file(tmp_path, name, text, said):
    with pytest.raises(InputError, match=said) as error:
        read_map(written(tmp_path / name, text))
    assert name in str(error.value)
    assert "\n" not in str(error.value)


def test_a_first_id_that_is_given_wins(tmp_path):
    path = written(tmp_path / "a.txt", "3\n1\n")
    assert read_map(path, 1).ids.tolist() == [2, 0]
    assert read_map(path, 0).ids.tolist() == [3, 1]


def test_a_map_beyond_its_target_is_refused():
    found = PointMap(np.array([0, 3]))
    found.check_target(4, 0, "a.map")
    with pytest.raises(InputError, match=r"a\.map names number 3 of a target of 3 points.*count from 1"):
        found.check_target(3, 0, "a.map")

"""MATLAB files as SciPy writes them, and damaged ones that end SciPy's reader."""

import struct
import warnings
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse
from scipy.io import loadmat, savemat

from datasets_gen import InputError
from datasets_gen.matlab_files import read_matlab


@pytest.mark.parametrize("packed", [True, False])
@pytest.mark.parametrize(
    "value",
    [
        {"X": np.arange(5.0)[:, None], "TRIV": np.ones((3, 3))},
        np.array([1, "a", np.eye(2)], dtype=object),
        "text",
        np.zeros((0, 0)),
        scipy.sparse.eye_array(3),
        np.ones(3) * 1j,
        np.arange(300, dtype=np.int16),
    ],
    ids=["struct", "cell", "text", "empty", "sparse", "complex", "short"],
)
def test_every_class_of_variables_is_read(tmp_path, packed, value):
    savemat(tmp_path / "a.mat", {"a": value, "second": 7.0}, do_compression=packed)
    found = read_matlab(tmp_path / "a.mat")
    assert set(found) == {"a", "second"}
    assert found["second"].item() == 7


@pytest.mark.parametrize(
    ("place", "value", "said"),
    [
        (184, 25, "data of the unknown type 25"),  # SciPy ends the process with a segmentation fault
        (132, 99999, "99999 bytes where"),
        (144, 77, "without its flags"),
        (188, 23, "23 bytes of numbers of 8"),
        (172, 39, "an array without its numbers"),  # a name as long as the rest: SciPy reads on behind it
        (152, 7, "an array without its size or its name"),
    ],
)
def test_a_damaged_tag_is_refused_with_one_line(tmp_path, place, value, said):
    savemat(tmp_path / "a.mat", {"matches": np.array([[1.0], [3], [2]]), "C": np.eye(2)})
    content = bytearray((tmp_path / "a.mat").read_bytes())
    content[place : place + 4] = struct.pack("<I", value)
    (tmp_path / "a.mat").write_bytes(content)
    with pytest.raises(InputError, match=said) as error:
        read_matlab(tmp_path / "a.mat")
    assert "a.mat" in str(error.value)
    assert "\n" not in str(error.value)


def test_files_that_matlab_wrote_are_read_as_by_scipy():
    """SciPy ships them; those with functions, and one of eight-byte numbers in one byte each, are refused."""
    refused = {"logical_sparse", "parabola", "some_functions", "sqr", "testfunc_7.4_GLNX86"}
    folder = Path(scipy.__file__).parent / "io/matlab/tests/data"
    files = [each for each in folder.glob("*.mat") if each.read_bytes()[:10] == b"MATLAB 5.0"]
    if not files:
        pytest.skip("this SciPy comes without its tests")
    read = 0
    for each in files:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                expected = {name for name in loadmat(each) if not name.startswith("__")}
            except Exception:  # one of those that are damaged on purpose
                continue
            if each.stem not in refused:
                assert set(read_matlab(each)) == expected, each.name
                read += 1
    assert read > 50


def test_other_levels_are_named(tmp_path):
    savemat(tmp_path / "old.mat", {"a": np.eye(2)}, format="4")
    with pytest.raises(InputError, match="level 5; export it again"):
        read_matlab(tmp_path / "old.mat")
    (tmp_path / "new.mat").write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512) + b"\x89HDF\r\n")
    with pytest.raises(InputError, match="save it with -v7"):
        read_matlab(tmp_path / "new.mat")

"""Files that are whole or not there, and what is said of others."""

import errno

import numpy as np
import pytest

from datasets_gen import Collection, Shape
from datasets_gen.records import InputError, atomic_path, load_record, save_record
from medial import Diffusion, Matching


def test_values_of_numpy_are_written_as_those_of_python(tmp_path):
    meta = {"seed": np.int64(3), "eta": np.float32(0.5), "on": np.True_, "sizes": np.arange(2)}
    save_record(tmp_path / "a.npz", "Test", {}, meta)
    assert load_record(tmp_path / "a.npz", "Test")[1] == {"seed": 3, "eta": 0.5, "on": True, "sizes": [0, 1]}


def test_paths_that_are_none_are_refused(tmp_path):
    for path, said in ((None, "None is no path"), (3, "3 is no path"), (tmp_path, "is a folder; choose")):
        with pytest.raises(InputError, match=said):
            save_record(path, "Test", {}, {})
    for path in (None, 3):
        with pytest.raises(InputError, match="is no path"):
            load_record(path, "Test")


def test_a_full_disk_names_the_file_and_leaves_nothing(tmp_path):
    with (
        pytest.raises(InputError, match=r"cannot write '.*a\.txt': No space left"),
        atomic_path(tmp_path / "a.txt"),
    ):
        raise OSError(errno.ENOSPC, "No space left on device")
    with (
        pytest.raises(FileNotFoundError),
        atomic_path(tmp_path / "a.txt"),
    ):  # of the writer: not about the file
        raise FileNotFoundError("other")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("cls", [Collection, Shape, Diffusion, Matching])
def test_files_of_another_version_or_format_are_refused(cls, tmp_path):
    kind, path = cls.__name__, tmp_path / "a.npz"
    for arrays, meta in (({}, {}), ({"x": np.zeros(3)}, {"config": {}}), ({}, {"config": 3, "units": 1})):
        save_record(path, kind, arrays, meta)
        with pytest.raises(InputError, match=f"is a {kind} file of another version"):
            cls.load(path)
    np.save(tmp_path / "a.npy", np.arange(3))
    with pytest.raises(InputError, match=f"not a readable {kind} file"):
        cls.load(tmp_path / "a.npy")

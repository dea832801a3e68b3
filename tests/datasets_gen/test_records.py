"""Files that are whole or not there, and what is said of others."""

import errno
import os
import stat
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

from datasets_gen import Collection, Shape
from datasets_gen.records import (
    InputError,
    atomic_path,
    file_content,
    leftovers,
    load_record,
    no_file,
    save_record,
)
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


def test_what_cannot_be_put_in_place_names_the_file_and_what_to_do(tmp_path, monkeypatch):
    said = {
        errno.EROFS: "Read-only file system; choose a folder",
        errno.EMFILE: "open files; raise the limit",
    }
    for number, words in said.items():
        with monkeypatch.context() as patch:
            error = OSError(number, "of another file", "/elsewhere")
            patch.setattr(Path, "replace", Mock(side_effect=error))
            patch.setattr(Path, "unlink", Mock(side_effect=OSError(errno.EBUSY, "busy")))
            with (
                pytest.raises(InputError, match=rf"cannot write '.*a\.txt': .*{words}"),
                atomic_path(tmp_path / "a.txt"),
            ):
                pass


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_pipes_and_devices_are_neither_read_nor_replaced(tmp_path):
    pipe, device = tmp_path / "pipe.npz", tmp_path / "device.npz"
    os.mkfifo(pipe)
    device.symlink_to("/dev/zero")
    (tmp_path / "plain").write_bytes(b"a")
    assert file_content(tmp_path / "plain") == b"a"
    for path in (pipe, device):
        for read in (file_content, lambda path: load_record(path, "Scan")):
            with pytest.raises(InputError, match=f"{path.name}' is a pipe or a device; give a"):
                read(path)
        with pytest.raises(InputError, match="it is a pipe or a device"), atomic_path(path):
            raise AssertionError
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert device.is_symlink()
    assert no_file(tmp_path) == "is a folder"
    assert no_file(tmp_path / "none") == no_file(tmp_path / "plain") == no_file("a\0b") == ""


def test_leftovers_are_the_temporary_files_of_killed_writers(tmp_path):
    for name in (".lock", ".lock-holder", ".probe-0123456789abcdef", "a.npz", "b-abcdefgh.npz"):
        (tmp_path / name).touch()
    assert leftovers(tmp_path) == []
    writing = atomic_path(tmp_path / "walk-0.2.npz")
    with writing as temporary:
        assert leftovers(tmp_path) == [temporary]
    assert leftovers(tmp_path) == []
    assert leftovers(tmp_path / "none") == []


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


def test_a_flipped_bit_anywhere_is_noticed_or_changes_nothing(tmp_path):
    path = tmp_path / "a.npz"
    arrays = {"long": np.arange(80.0).reshape(8, 10), "short": np.arange(3)}
    save_record(path, "Test", arrays, {"units": "mm", "sizes": [1, 2]})
    whole, noticed = path.read_bytes(), 0
    for place in range(len(whole)):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << (place % 8)
        path.write_bytes(damaged)
        try:
            found, meta = load_record(path, "Test")
        except InputError:
            noticed += 1
            continue
        assert meta == {"units": "mm", "sizes": [1, 2]}
        assert found.keys() == arrays.keys()
        assert all(np.array_equal(found[name], arrays[name]) for name in arrays)
    assert noticed > 0.7 * len(whole)  # dates in a zip archive and the like may be anything


def test_an_array_shorter_in_its_header_than_in_the_file(tmp_path):
    """A reader that stops early never compares the checksum, which is at the end."""
    path = tmp_path / "a.npz"
    save_record(path, "Test", {"x": np.arange(8000)}, {})
    whole = path.read_bytes()
    assert whole.count(b"(8000,)") == 1
    path.write_bytes(whole.replace(b"(8000,)", b"(0000,)"))
    with pytest.raises(InputError, match="longer than its header says"):
        load_record(path, "Test")


def test_files_of_earlier_versions_do_not_count_their_arrays(tmp_path):
    np.savez(tmp_path / "a.npz", kind=np.array("Test"), meta=np.array('{"units": "m"}'), x=np.arange(3))
    arrays, meta = load_record(tmp_path / "a.npz", "Test")
    assert (arrays["x"].tolist(), meta) == ([0, 1, 2], {"units": "m"})


def test_a_name_of_full_length_can_be_written(tmp_path):
    path = tmp_path / f"{251 * 'x'}.npz"
    with atomic_path(path) as temporary:
        temporary.write_bytes(b"1")
        assert leftovers(tmp_path) == [temporary]
    assert path.read_bytes() == b"1"

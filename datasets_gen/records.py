"""Files that are never half-written, and the one error type for bad input.

The leftmost package owns these because every other package uses them.
"""

import errno
import json
import os
import re
import stat
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

_COUNT = "arrays"
"""Entry of a record's metadata that says how many arrays there are."""

_OTHER_FOLDER = "choose a folder you can write to"
_MORE_FILES = "raise the limit of open files (ulimit -n)"
_WAYS_OUT = {
    errno.ENOSPC: "free some space, or choose another folder",
    errno.EDQUOT: "free some space, or choose another folder",
    errno.EFBIG: "raise the limit of a file's size (ulimit -f), or choose another folder",
    errno.EIO: _OTHER_FOLDER,
    errno.EROFS: _OTHER_FOLDER,
    errno.EMFILE: _MORE_FILES,
    errno.ENFILE: _MORE_FILES,
}
"""What to do about a system that cannot take a file, whatever the writer does."""

_TEMPORARY = re.compile(r"\..+-[a-z0-9_]{8}(\.[^.]*)?")
"""Names that `atomic_path` gives while it writes."""


class InputError(ValueError):
    """Input that cannot be used; the message is one line: what is wrong, the value, what to do."""


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary path beside `path`; rename it to `path` on success, remove it on failure.

    Parameters
    ----------
    path
        The file to write. Missing parent folders are created. The temporary name keeps the suffix, as
        writers choose the format by it.

    Raises
    ------
    InputError
        If it is no path or a folder, its folder cannot be created or written, or the device is full.
    """
    target = as_path(path)
    if what := no_file(target):
        raise InputError(f"cannot write {str(target)!r}: it {what}; choose another name, or remove it")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        start = f".{target.stem[:30]}-"  # a name of full length has no room for more letters
        handle, name = tempfile.mkstemp(prefix=start, suffix=target.suffix, dir=target.parent)
    except OSError as error:
        raise cannot_write(target, error) from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        _put_in_place(temporary, target)
    except BaseException as error:
        with suppress(OSError):  # what went wrong before it is what is said
            temporary.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno in _WAYS_OUT:
            raise cannot_write(target, error) from error
        raise


def _put_in_place(temporary: Path, target: Path) -> None:
    try:
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)  # mkstemp's 0600 would hide results from a group
        temporary.replace(target)
    except OSError as error:
        raise cannot_write(target, error) from error


def cannot_write(target: str | os.PathLike[str], error: OSError) -> InputError:
    """What is said of a file or a folder that the system does not let be written, and what to do."""
    reason = os.strerror(error.errno) if error.errno else str(error)
    what_to_do = _WAYS_OUT.get(error.errno or 0, _OTHER_FOLDER)
    return InputError(f"cannot write {str(target)!r}: {reason}; {what_to_do}")


def leftovers(folder: str | os.PathLike[str]) -> list[Path]:
    """Temporary files in a folder, of processes that were killed while they wrote, or write still."""
    try:
        return sorted(each for each in Path(folder).iterdir() if _TEMPORARY.fullmatch(each.name))
    except OSError:
        return []


def no_file(path: str | os.PathLike[str]) -> str:
    """What a path is if it is no file: ``"is a folder"``, or a pipe or a device; empty for a file or nothing.

    A pipe keeps its reader waiting, and a device such as ``/dev/zero`` has no end.
    """
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):  # there is nothing, or the system does not tell
        return ""
    return "" if stat.S_ISREG(mode) else "is a folder" if stat.S_ISDIR(mode) else "is a pipe or a device"


def file_content(path: Path) -> bytes:
    """The bytes of a file.

    Raises
    ------
    InputError
        If it is a pipe or a device.
    OSError
        If it is a folder, or cannot be read.
    """
    if (what := no_file(path)) and not path.is_dir():
        raise InputError(f"{str(path)!r} {what}; give a file")
    return path.read_bytes()


def as_path(path: Any) -> Path:
    """The path; InputError if it is none."""
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"{path!r} is no path of a file; give one")
    return Path(path)


def save_record(
    path: str | os.PathLike[str], kind: str, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]
) -> None:
    """Write named arrays and JSON metadata as one `.npz`, atomically.

    Not compressed: that saves 5 % of measured or computed floats and takes forty times as long.

    Parameters
    ----------
    path
        Target file; ``.npz`` is the conventional suffix.
    kind
        Name of the record's type, checked by `load_record`.
    arrays
        Arrays by name. The names ``kind`` and ``meta`` are taken.
    meta
        Values that JSON can hold; NumPy's are written as Python's.
    """
    with atomic_path(path) as temporary, temporary.open("wb") as stream:
        fields: dict[str, Any] = {
            "kind": np.array(kind),
            "meta": np.array(json.dumps({**meta, _COUNT: len(arrays)}, default=_plain)),
            **arrays,
        }
        np.savez(stream, **fields)


def _plain(value: Any) -> Any:
    """A scalar or an array of NumPy as JSON can hold it."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"a record cannot hold {value!r}")


def load_record(path: str | os.PathLike[str], kind: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Read a file written by `save_record`.

    Returns
    -------
    arrays, meta

    Raises
    ------
    InputError
        If the file is missing, cut short, or holds another kind of record.
    """
    if what := no_file(as_path(path)):
        raise InputError(f"{str(path)!r} {what}; give a {kind} file")
    try:
        with ZipFile(as_path(path)) as file:
            found = str(_array(file, "kind")) if "kind.npy" in file.namelist() else "no medialbench record"
            if found != kind:
                raise InputError(f"{str(path)!r} holds {found!r}, not {kind!r}")
            meta = json.loads(str(_array(file, "meta")))
            names = {name.removesuffix(".npy") for name in file.namelist()} - {"kind", "meta"}
            if meta.pop(_COUNT, len(names)) != len(names):
                raise ValueError("arrays are missing")
            return {name: _array(file, name) for name in sorted(names)}, meta
    except FileNotFoundError as error:
        raise InputError(f"{str(path)!r} does not exist") from error
    except InputError:
        raise
    except Exception as error:  # a damaged archive makes its reader raise anything
        raise InputError(f"{str(path)!r} is not a readable {kind} file ({error}); make it again") from error


def _array(file: ZipFile, name: str) -> NDArray[Any]:
    """An array of an archive, all of it: its checksum is compared when its end is reached, not before."""
    with file.open(f"{name}.npy") as stream:
        array: NDArray[Any] = np.lib.format.read_array(stream, allow_pickle=False)
        if stream.read(1):
            raise ValueError(f"{name} is longer than its header says")
    return array


@contextmanager
def unpacking(path: str | os.PathLike[str], kind: str) -> Iterator[None]:
    """A context in which what `load_record` gave is put together: what a file lacks is an `InputError`."""
    try:
        yield
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"{str(path)!r} is a {kind} file of another version ({error}); make it again"
        ) from error

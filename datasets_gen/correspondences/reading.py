"""Reading of correspondence files: understood or refused, with the line that is wrong."""

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.correspondences.point_map import FORMATS, ON_TRIANGLES, PointMap
from datasets_gen.matlab_files import read_matlab
from datasets_gen.records import InputError, no_file

NAMES = ("source_to_target", "p2p", "matches", "match", "map", "corr", "correspondence", "vts", "T")
"""Variables of ``.mat`` files and columns of ``.csv`` files that hold a map: the first there is."""


def read_map(path: Path, first_id: int | None = None, *, otherwise: int | None = None) -> PointMap:
    """Read a correspondence file.

    Parameters
    ----------
    path
        Its ending is one of `point_map.FORMATS`.
    first_id
        Index of the first target point: 0 or 1. Default: what the file's header says, or that of the format.
    otherwise
        The same, of a file whose format and header do not tell. Default: such a file is refused.

    Raises
    ------
    InputError
        If the file is missing, not understood, or does not say from where it counts.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise InputError(f"{str(path)!r} is no correspondence file; it may end in {', '.join(FORMATS)}")
    if not path.is_file():
        raise InputError(f"{str(path)!r} {no_file(path) or 'does not exist'}; give a map")
    if first_id not in (None, 0, 1):
        raise InputError(f"indices count from 0 or 1, not from {first_id!r}")
    try:
        if suffix in (".npz", ".npy"):
            return _numpy(path, first_id or 0)
        if suffix == ".mat":
            return _matlab(path, first_id)
        return _text(path, suffix, first_id, otherwise)
    except InputError as error:
        if str(path) in str(error):
            raise
        raise InputError(f"{str(path)!r}: {error}") from error
    except Exception as error:  # readers of NumPy and SciPy raise anything on a broken file
        said = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{str(path)!r} is not a readable correspondence ({said})") from error


def _counted(values: Any, first_id: int) -> NDArray[np.int64]:
    """Indices from 0; what lies below the first, or is NaN, is -1.

    Raises
    ------
    InputError
        If one is no whole number, or lies more than one below the first.
    """
    if (kind := np.asarray(values).dtype).kind in "bc":
        raise InputError(f"values of type {kind} are no indices; give whole numbers")
    numbers = np.asarray(values, dtype=np.float64).ravel()
    given = ~np.isnan(numbers)
    wrong = given & ((numbers != np.round(numbers)) | (np.abs(numbers) > 2**52))
    if wrong.any():
        raise InputError(f"entry {wrong.argmax() + 1} is {numbers[wrong.argmax()]:g}, no index")
    low = given & (numbers < -1)
    if low.any():
        raise InputError(f"entry {low.argmax() + 1} is {numbers[low.argmax()]:g}; -1 means no match")
    ids = np.where(given, numbers, -1).astype(np.int64)
    return np.where(ids < first_id, -1, ids - first_id)


def _sure(values: Any) -> NDArray[np.float64] | None:
    """A confidence, checked."""
    if values is None:
        return None
    found = np.asarray(values, dtype=np.float64).ravel()
    wrong = ~((found >= 0) & (found <= 1))
    if wrong.any():
        row = int(wrong.argmax())
        raise InputError(f"the confidence of entry {row + 1} is {found[row]:g}; it must lie in [0, 1]")
    return found


def _numpy(path: Path, first_id: int) -> PointMap:
    """A ``.npy`` of indices, or a ``.npz`` with ``source_to_target`` and perhaps ``confidence``."""
    if path.suffix.lower() == ".npy":
        array = np.load(path, allow_pickle=False)
        if array.ndim != 1 and 1 not in array.shape:
            raise InputError(f"an array of shape {array.shape} is no list of indices")
        return PointMap(_counted(array, first_id))
    with np.load(path, allow_pickle=False) as data:
        if "source_to_target" not in data:
            raise InputError(f"source_to_target is missing; there are {', '.join(data.files) or 'no arrays'}")
        confidence = data.get("confidence")
        return PointMap(_counted(data["source_to_target"], first_id), confidence=_sure(confidence))


def _matlab(path: Path, first_id: int | None) -> PointMap:
    """A variable of a ``.mat`` file, named like a map."""
    given = read_matlab(path)
    name = next((name for name in NAMES if name in given), None)
    if name is None:
        raise InputError(
            f"no variable is called {' or '.join(NAMES)}; there are {', '.join(given) or 'none'}"
        )
    if first_id is None:
        first_id = int(np.ravel(given["first_id"])[0]) if "first_id" in given else 1
    return PointMap(_counted(given[name], first_id), confidence=_sure(given.get("confidence")))


def _text(path: Path, suffix: str, first_id: int | None, otherwise: int | None) -> PointMap:
    """Rows of numbers, in the columns of the format."""
    first, rows, names = _rows(path)
    told = (first_id, first, FORMATS[suffix][0], otherwise)
    first_id = next((each for each in told if each is not None), None)
    table = _table(rows, path)
    if suffix in ON_TRIANGLES:
        if len(rows) and table.shape[1] != 4:
            raise InputError(f"{table.shape[1]} columns; give a triangle and three weights per line")
        table = table.reshape(-1, 4)
        ids = _counted(table[:, 0], 1 if first_id is None else first_id)
        return PointMap(ids, np.where(ids[:, None] >= 0, table[:, 1:], 0.0))
    columns, sure = _columns(names, table, suffix)
    if first_id is None:
        raise InputError(
            "the file does not say whether indices count from 0 or 1; say it (first_id, --first-id), "
            "or begin the file with '# first_id = 0'"
        )
    return PointMap(_counted(columns, first_id), confidence=_sure(sure))


def _columns(
    names: list[str], table: NDArray[np.float64], suffix: str
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Indices and confidences of a table: by the names of the columns, or one or two without names."""
    table = table if table.size else table.reshape(0, max(1, len(names)))
    if names:
        known = {name.lower(): k for k, name in enumerate(names)}
        column = next((known[name] for name in ("target", *map(str.lower, NAMES)) if name in known), None)
        if column is None:
            raise InputError(f"no column is called target; there are {', '.join(names)}")
        if "source" in known:
            order = table[:, known["source"]]
            if not (
                np.array_equal(order, np.arange(len(order)))
                or np.array_equal(order, np.arange(1, len(order) + 1))
            ):
                raise InputError("the column source does not count all points in order")
        sure = table[:, known["confidence"]] if "confidence" in known else None
        return table[:, column], sure
    limit = 1 if suffix in (".vts", ".map") else 2
    if table.shape[1] > limit:
        wanted = "an index" if limit == 1 else "an index and a confidence"
        raise InputError(f"{table.shape[1]} columns without names; give {wanted} per line")
    return table[:, 0], table[:, 1] if table.shape[1] == 2 else None


def _rows(path: Path) -> tuple[int | None, list[tuple[int, list[str]]], list[str]]:
    """First index that the header tells, numbered rows of words, and names of columns where there are."""
    text = path.read_bytes().decode("utf-8-sig", errors="replace")
    first, rows, names = None, list[tuple[int, list[str]]](), list[str]()
    for number, line in enumerate(text.splitlines(), 1):
        comment = line.partition("#")[2] if "#" in line else line.partition("%")[2]
        told = re.search(r"first_id\s*=\s*([01])\b", comment)
        first = int(told[1]) if told and first is None else first
        words = re.split(r"[\s,;]+", re.split(r"[#%]", line)[0].strip(" \t,;"))
        if words == [""]:
            continue
        if (
            not rows
            and not names
            and all(re.fullmatch(r"[A-Za-z_]\w*", w) and w.lower() != "nan" for w in words)
        ):
            names = words
            continue
        rows.append((number, words))
    return first, rows, names


def _table(rows: list[tuple[int, list[str]]], path: Path) -> NDArray[np.float64]:
    """Words as numbers, as many in every row."""
    for number, words in rows:
        if len(words) != len(rows[0][1]):
            raise InputError(
                f"{str(path)!r}, line {number}, has {len(words)} columns, line {rows[0][0]} {len(rows[0][1])}"
            )
        for word in words:
            try:
                float(word)
            except ValueError as error:
                raise InputError(f"{str(path)!r}, line {number}: {word!r} is no number") from error
    return np.array([[float(word) for word in words] for _, words in rows], dtype=np.float64)

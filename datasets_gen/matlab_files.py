"""MATLAB files (level 5, the default of ``save -v7`` and before), checked before SciPy reads them.

SciPy trusts the tags of a file: an unknown type in a damaged one ends the process. So they are walked first.
"""

import math
import zlib
from pathlib import Path
from typing import Any, NamedTuple

from datasets_gen.records import InputError

HEADER = 128
MATRIX, COMPRESSED = 14, 15
TYPES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, MATRIX: 1, 16: 1, 17: 2, 18: 4}
"""Known types of data elements, with the bytes of one number."""
INT8, INT32, UINT32, UTF8 = 1, 5, 6, 16
SIZE_AND_NAME = tuple([size, name] for size in (INT32, UINT32) for name in (INT8, UTF8))
CLASSES = frozenset(range(1, 16))
CELL, SPARSE = 1, 5
RECORDS = frozenset([2, 3])
OBJECT = 3
COMPLEX = 0x800
"""Flag of an array with imaginary parts."""
LARGEST = 1 << 30
"""Bytes of a variable after decompression: a mesh of a million vertices takes 50 MB."""
DEEPEST = 20


def read_matlab(path: Path) -> dict[str, Any]:
    """The variables of a ``.mat`` file, by name.

    Raises
    ------
    InputError
        If the file cannot be read, is damaged, or of MATLAB's level 4 or 7.3.
    """
    from scipy.io import loadmat

    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read: {error.strerror}") from error
    if content[:10] != b"MATLAB 5.0" or content[126:128] not in (b"IM", b"MI"):
        hint = (
            "save it with -v7"
            if b"HDF" in content[:HEADER] or b"7.3" in content[:HEADER]
            else "export it again"
        )
        raise InputError(f"{str(path)!r} is no MATLAB file of level 5; {hint}")
    try:
        _walk(memoryview(content)[HEADER:], "little" if content[126:128] == b"IM" else "big", 0)
        found = loadmat(path)
    except Exception as error:  # SciPy raises anything on a broken file
        said = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{str(path)!r} is cut short or damaged ({said}); export it again") from error
    return {name: value for name, value in found.items() if not name.startswith("__")}


class _Element(NamedTuple):
    """A data element: its type and its bytes."""

    kind: int
    data: memoryview


def _walk(data: memoryview, order: Any, depth: int) -> list[_Element]:
    """The elements, and all within them, checked; raises ValueError for the first that is wrong."""
    if depth > DEEPEST:
        raise ValueError("arrays are nested too deeply")
    place, found = 0, list[_Element]()
    while place < len(data):
        if len(data) - place < 8:
            raise ValueError("a tag is cut short")
        kind = int.from_bytes(data[place : place + 4], order)
        size, start = int.from_bytes(data[place + 4 : place + 8], order), place + 8
        if kind >> 16:  # small element: its size in the upper half, its data within the tag
            kind, size, start = kind & 0xFFFF, kind >> 16, place + 4
            if size > 4:
                raise ValueError(f"a small element of {size} bytes")
        packed = kind == COMPRESSED and depth == 0
        if not packed and kind not in TYPES:
            raise ValueError(f"data of the unknown type {kind}")
        if start + size > len(data):
            raise ValueError(f"an element of {size} bytes where {len(data) - start} are left")
        if not packed and size % TYPES[kind]:
            raise ValueError(f"{size} bytes of numbers of {TYPES[kind]}")
        inside = data[start : start + size]
        if packed:
            _walk(memoryview(_unpacked(inside)), order, 1)
        elif kind == MATRIX and size:
            _check_array(_walk(inside, order, depth + 1), order)
        found.append(_Element(kind, inside))
        end = start + size
        place = place + 8 if start == place + 4 else end if packed else end + -end % 8
    return found


def _check_array(parts: list[_Element], order: Any) -> None:
    """Raise ValueError unless the elements of an array are those that its class and size ask for."""
    flags = parts[0] if parts else _Element(0, memoryview(b""))
    word = int.from_bytes(flags.data[:4], order)
    kind, is_complex = word & 0xFF, bool(word & COMPLEX)
    if (flags.kind, len(flags.data)) != (UINT32, 8) or kind not in CLASSES:
        raise ValueError("an array without its flags")
    if [part.kind for part in parts[1:3]] not in SIZE_AND_NAME:
        raise ValueError("an array without its size or its name")
    sides = [int.from_bytes(parts[1].data[k : k + 4], order) for k in range(0, len(parts[1].data), 4)]
    count, rest = math.prod(sides), parts[3:]
    if kind == CELL:
        arrays, wanted = rest, count
    elif kind in RECORDS:
        if kind == OBJECT:  # its class's name first
            rest = rest[1:]
        length = int.from_bytes(rest[0].data[:4], order) if rest else 0
        if len(rest) < 2 or length < 1 or [part.kind for part in rest[:2]] != [INT32, INT8]:
            raise ValueError("a structure without the names of its fields")
        arrays, wanted = rest[2:], count * (len(rest[1].data) // length)
    else:
        arrays, wanted = [], 0
        if len(rest) != (2 if kind == SPARSE else 0) + 1 + is_complex or any(p.kind == MATRIX for p in rest):
            raise ValueError("an array without its numbers")
    if len(arrays) != wanted or any(part.kind != MATRIX for part in arrays):
        raise ValueError(f"{len(arrays)} arrays in one of {wanted}")


def _unpacked(data: memoryview) -> bytes:
    """What a compressed element holds."""
    stream = zlib.decompressobj()
    content = stream.decompress(data, LARGEST)
    if stream.unconsumed_tail:
        raise ValueError(f"a variable of more than {LARGEST >> 20} MB")
    return content

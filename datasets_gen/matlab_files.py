"""MATLAB files (level 5, the default of ``save -v7`` and before), checked before SciPy reads them.

SciPy trusts the tags of a file: an unknown type in a damaged one ends the process. So they are walked first.
"""

import zlib
from pathlib import Path
from typing import Any

from datasets_gen.records import InputError

HEADER = 128
MATRIX, COMPRESSED = 14, 15
TYPES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, MATRIX: 1, 16: 1, 17: 2, 18: 4}
"""Known types of data elements, with the bytes of one number."""
CLASSES = frozenset(range(1, 16))
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


def _walk(data: memoryview, order: Any, depth: int) -> None:
    """Check the tags of all elements; raises ValueError for the first that is wrong."""
    if depth > DEEPEST:
        raise ValueError("arrays are nested too deeply")
    place, first = 0, True
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
        if packed:
            _walk(memoryview(_unpacked(data[start : start + size])), order, 1)
        elif kind == MATRIX and size:
            _walk(data[start : start + size], order, depth + 1)
        elif depth and first:  # flags of an array: its class
            word = int.from_bytes(data[start : start + 4], order)
            if kind != 6 or size != 8 or word & 0xFF not in CLASSES:
                raise ValueError("an array without its flags")
        first = False
        end = start + size
        place = place + 8 if start == place + 4 else end if packed else end + -end % 8


def _unpacked(data: memoryview) -> bytes:
    """What a compressed element holds."""
    stream = zlib.decompressobj()
    content = stream.decompress(data, LARGEST)
    if stream.unconsumed_tail:
        raise ValueError(f"a variable of more than {LARGEST >> 20} MB")
    return content

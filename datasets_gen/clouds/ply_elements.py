"""The tables of a PLY file, ascii or binary of either byte order: a column per property, lists among them."""

import re
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

_NUMBERS = "char i1 int8 i1 uchar u1 uint8 u1 short i2 int16 i2 ushort u2 uint16 u2 int i4 int32 i4 uint u4"
_NUMBERS += " uint32 u4 int64 i8 uint64 u8 float f4 float32 f4 double f8 float64 f8"
TYPES = dict(zip(_NUMBERS.split()[::2], _NUMBERS.split()[1::2], strict=True))
"""Types of numbers, as NumPy calls them."""
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
LONGEST_HEADER = 1 << 20


class ListColumn(NamedTuple):
    """A list per row: their lengths (n,), and all of their numbers one after the other."""

    lengths: NDArray[np.int64]
    values: NDArray[Any]


@dataclass(frozen=True)
class Property:
    """A property of an element: its type, and that of the length of a list."""

    name: str
    kind: str
    length: str = ""


@dataclass(frozen=True)
class PlyElement:
    """A table of a PLY file: `columns` by name, each an array (n,) or `ListColumn`."""

    name: str
    count: int
    properties: list[Property] = field(default_factory=list)
    columns: dict[str, Any] = field(default_factory=dict)


def read_elements(content: bytes) -> tuple[dict[str, PlyElement], int]:
    """All tables of a PLY file.

    Returns
    -------
    elements
        By name.
    left
        Number of bytes after the last of them.

    Raises
    ------
    ValueError
        If the file is not as its header says.
    """
    content = content.removeprefix(b"\xef\xbb\xbf")
    elements, order, start = _header(content)
    place = start if order else 0
    words = [] if order else _rows(content[start:])
    for element in elements:
        place = _binary(element, content, place, order) if order else _ascii(element, words, place)
    left = len(content) - place if order else sum(map(len, words[place:]))
    return {element.name: element for element in elements}, left


def _header(content: bytes) -> tuple[list[PlyElement], str, int]:
    """Elements without data, byte order (empty for ascii), and where data begins."""
    found = re.search(rb"^\s*end_header[ \t]*(\r\n|\n|\r)?", content[:LONGEST_HEADER], re.MULTILINE)
    ended = found or re.search(rb"\rend_header[ \t]*(\r\n|\n|\r)?", content[:LONGEST_HEADER])
    if not content[:3].lower() == b"ply" or ended is None:
        raise ValueError("no line 'ply' at the start, or no line 'end_header'")
    elements, order = list[PlyElement](), None
    for line in content[: ended.start()].decode("utf-8", "replace").splitlines():
        words = line.split() or [""]
        if words[0] == "format":
            order = ORDERS.get(words[1] if len(words) > 1 else "")
        elif words[0] == "element":
            name, count = words[1:3]
            elements.append(PlyElement(name, int(count)))
            if int(count) < 0:
                raise ValueError(f"{count} rows of kind {name!r}")
            if any(each.name == name for each in elements[:-1]):
                raise ValueError(f"the header has two elements {name!r}")
        elif words[0] == "property":
            is_list = words[1:2] == ["list"]
            length, kind = (TYPES[words[2]], TYPES[words[3]]) if is_list else ("", TYPES[words[1]])
            if any(each.name == words[-1] for each in elements[-1].properties):
                raise ValueError(f"the header names {words[-1]!r} of {elements[-1].name!r} twice")
            elements[-1].properties.append(Property(words[-1], kind, length))
    if order is None:
        raise ValueError("no line 'format ascii 1.0', or binary_little_endian, or binary_big_endian")
    return elements, order, ended.end()


def _rows(body: bytes) -> list[list[bytes]]:
    """Words of the lines that have some."""
    return [words for words in map(bytes.split, body.splitlines()) if words]


def _ascii(element: PlyElement, rows: list[list[bytes]], place: int) -> int:
    """Read a table in text; gives the first row after it."""
    if not element.properties:
        return place
    mine = rows[place : place + element.count]
    if len(mine) < element.count:
        raise ValueError(f"{len(mine)} rows of kind {element.name!r} where {element.count} should be")
    at = np.zeros(len(mine), dtype=np.int64)
    plain = not any(each.length for each in element.properties)
    if plain:
        wide = len(element.properties)
        table = np.array([row[:wide] for row in mine]).astype(np.float64).reshape(-1, wide)
        for k, each in enumerate(element.properties):
            element.columns[each.name] = table[:, k]
        return place + element.count
    for each in element.properties:
        if not each.length:
            element.columns[each.name] = np.array(
                [float(row[k]) for row, k in zip(mine, at, strict=True)], dtype=np.float64
            )
            at += 1
            continue
        lengths = np.array([int(row[k]) for row, k in zip(mine, at, strict=True)], dtype=np.int64)
        parts = [row[k + 1 : k + 1 + n] for row, k, n in zip(mine, at, lengths, strict=True)]
        if any(n < 0 or len(part) != n for part, n in zip(parts, lengths, strict=True)):
            raise ValueError(f"a list of kind {element.name!r} is cut short")
        joined = [word for part in parts for word in part]
        element.columns[each.name] = ListColumn(lengths, _numbers(joined, each.kind))
        at += 1 + lengths
    return place + element.count


def _numbers(words: list[bytes], kind: str) -> NDArray[Any]:
    """Words as numbers; whole ones stay whole."""
    if kind.startswith("f"):
        return np.array([float(word) for word in words], dtype=np.float64)
    return np.array([int(word) for word in words], dtype=np.int64)


def _binary(element: PlyElement, content: bytes, place: int, order: str) -> int:
    """Read a table in binary; gives the first byte after it."""
    if not element.properties or not element.count:
        for each in element.properties:
            empty = np.zeros(0)
            element.columns[each.name] = ListColumn(empty.astype(np.int64), empty) if each.length else empty
        return place
    sizes = _first_lengths(element, content, place, order)
    fields = list[tuple[Any, ...]]()
    for k, each in enumerate(element.properties):
        if each.length:
            fields.append((f"n{k}", order + each.length))
            fields.append((f"v{k}", order + each.kind, (sizes[k],)))
        else:
            fields.append((f"v{k}", order + each.kind))
    kind = np.dtype(fields)
    end = place + kind.itemsize * element.count
    lists = [k for k, each in enumerate(element.properties) if each.length]
    if end > len(content) and not lists:
        there = (len(content) - place) // kind.itemsize
        raise ValueError(f"{there} rows of kind {element.name!r} where {element.count} should be")
    if end <= len(content):
        table = np.frombuffer(content, kind, element.count, place)
        if all((table[f"n{k}"] == sizes[k]).all() for k in lists):
            for k, each in enumerate(element.properties):
                values = _native(table[f"v{k}"])
                lengths = np.full(element.count, sizes.get(k, 0), dtype=np.int64)
                element.columns[each.name] = ListColumn(lengths, values.ravel()) if each.length else values
            return end
    return _walked(element, content, place, order)


def _first_lengths(element: PlyElement, content: bytes, place: int, order: str) -> dict[int, int]:
    """Lengths of the lists of the first row, by number of the property."""
    found = {}
    for k, each in enumerate(element.properties):
        size = np.dtype(each.kind).itemsize
        if each.length:
            found[k] = int(np.frombuffer(content, order + each.length, 1, place)[0])
            if found[k] < 0 or found[k] * size > len(content) - place:
                raise ValueError(f"a list of {found[k]} numbers, beyond the end of the file")
            place += np.dtype(each.length).itemsize
        place += size * found.get(k, 1)
    return found


def _walked(element: PlyElement, content: bytes, place: int, order: str) -> int:
    """Read a table whose lists differ in length, row by row."""
    kinds = [(np.dtype(order + (e.length or e.kind)), np.dtype(order + e.kind)) for e in element.properties]
    least = sum(first.itemsize for first, _ in kinds)
    if least * element.count > len(content) - place:
        raise ValueError(f"{element.count} rows of kind {element.name!r} do not fit into the file")
    lengths: list[list[int]] = [[] for _ in kinds]
    parts: list[list[NDArray[Any]]] = [[] for _ in kinds]
    for row in range(element.count):
        for k, (first, kind) in enumerate(kinds):
            if place + first.itemsize > len(content):
                raise ValueError(f"{row} rows of kind {element.name!r} where {element.count} should be")
            count = 1
            if element.properties[k].length:
                count = int(np.frombuffer(content, first, 1, place)[0])
                place += first.itemsize
                if count < 0 or count * kind.itemsize > len(content) - place:
                    raise ValueError(
                        f"row {row + 1} of kind {element.name!r} has a list of {count} numbers, "
                        "beyond the end of the file"
                    )
            parts[k].append(np.frombuffer(content, kind, count, place))
            lengths[k].append(count)
            place += kind.itemsize * count
    for k, each in enumerate(element.properties):
        values = _native(np.concatenate(parts[k]))
        if each.length:
            element.columns[each.name] = ListColumn(np.array(lengths[k], dtype=np.int64), values)
        else:
            element.columns[each.name] = values
    return place


def _native(values: NDArray[Any]) -> NDArray[Any]:
    """Whole numbers as int64, others as float64, in the byte order of the machine."""
    return values.astype(np.float64 if values.dtype.kind == "f" else np.int64)

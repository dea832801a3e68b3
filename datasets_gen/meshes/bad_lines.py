"""The first line of a mesh or cloud file in text that cannot be right: parsers say what, but not where."""

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

Line = tuple[int, list[bytes]]
"""Number of a line, counted from 1, and its words."""
TYPES = frozenset(
    b"char uchar short ushort int uint float double "
    b"int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64".split()
)
"""Of the numbers in a ``.ply``."""
FACES = (b"vertex_indices", b"vertex_index")
NOWHERE = ""


class _Fault(Exception):
    """What is wrong with a line."""


@dataclass
class _Element:
    """What the header of a ``.ply`` says of rows of one kind."""

    name: str
    count: int
    lists: list[bool] = field(default_factory=list)
    properties: list[bytes] = field(default_factory=list)


def bad_line(file: Path, thorough: bool = True) -> str:
    """The first line of a ``.ply``, ``.off`` or ``.obj`` in text that is wrong, and what is wrong with it.

    Parameters
    ----------
    file
    thorough
        Look at every number. If not, only at the rows that a ``.ply`` or an ``.off`` should have and at how
        many numbers are in each, which is faster: parsers leave out rows that are too short.

    Returns
    -------
    str
        As ``line 7: 2 numbers where three are needed``; empty if there is nothing to say, and for a ``.ply``
        that is not in text.
    """
    content = file.read_bytes()
    readers: dict[str, Callable[[bytes, bool], None]] = {".ply": _ply, ".off": _off, ".obj": _obj}
    try:
        readers[file.suffix.lower()](content, thorough)
    except _Fault as fault:
        return str(fault)
    return NOWHERE


def _ply(content: bytes, thorough: bool) -> None:
    content = re.sub(rb"\r\n?", b"\n", content.removeprefix(b"\xef\xbb\xbf"))
    ended = re.search(rb"^[ \t]*end_header", content, re.MULTILINE)
    head, end, body = (
        (content, b"", b"") if ended is None else (content[: ended.start()], ended[0], content[ended.end() :])
    )
    lines = head.splitlines()
    words = [line.split() or [b""] for line in lines]
    binary = [b"format", b"ascii"] not in [each[:2] for each in words]
    if binary and any(each[0] == b"format" for each in words):
        return
    if not words or [each.lower() for each in words[0]] != [b"ply"]:
        raise _Fault("line 1 is not 'ply'")
    elements: list[_Element] = []
    for number, each in enumerate(words, 1):
        if each[0] == b"element":
            elements.append(_Element(_text(each[1:2]), _count(number, each[2:3])))
        elif each[0] == b"property":
            _add_property(number, each, elements)
        elif each[0].lower() != b"ply" and each[0] not in (b"format", b"comment", b"obj_info", b""):
            raise _Fault(f"line {number}: {_text(each)!r} is no line of a header, which ends with end_header")
    if not end:
        raise _Fault(f"line {len(lines)}: the header does not end with end_header")
    if binary:
        raise _Fault("line 2: the header has no line 'format ascii 1.0'")
    rows = _Rows(body.partition(b"\n")[2], len(lines) + 2, comments=False)
    vertices = next((each.count for each in elements if each.name == "vertex"), 0)
    for element in elements:
        lacking = [each for each in (b"x", b"y", b"z") if each not in element.properties]
        if element.name == "vertex" and lacking:
            raise _Fault(f"the header names no property {_text(lacking)!r} of vertices")
        for k in range(element.count):
            row = rows.take(k, element.count, element.name)
            _check_ply_row(row, element, vertices, thorough)


def _add_property(number: int, words: list[bytes], elements: list[_Element]) -> None:
    """Note a line such as ``property float x`` or ``property list uchar int vertex_indices``."""
    is_list = words[1:2] == [b"list"]
    types = words[2:4] if is_list else words[1:2]
    if len(words) != (5 if is_list else 3) or not elements:
        raise _Fault(f"line {number}: {_text(words)!r} is no property")
    for each in types:
        if each not in TYPES:
            raise _Fault(f"line {number}: {_text([each])!r} is no type of number")
    elements[-1].lists.append(is_list)
    elements[-1].properties.append(words[-1])


def _check_ply_row(row: Line, element: _Element, vertices: int, thorough: bool) -> None:
    number, words = row
    place = 0
    for is_list, name in zip(element.lists, element.properties, strict=True):
        size = _integer(number, words[place : place + 1], "the length of a list") if is_list else 0
        if is_list and name in FACES and thorough:
            _check_face(row, words[place + 1 : place + 1 + size], vertices)
        place += 1 + size
    if place > len(words):
        raise _Fault(f"line {number}: {len(words)} numbers where {place} are needed")
    if thorough:
        _numbers(number, words[:place])


def _off(content: bytes, thorough: bool) -> None:
    rows = _Rows(content, 1, comments=True)
    number, words = next(rows, (1, [b""]))
    if not words[0].upper().endswith(b"OFF"):
        raise _Fault(f"line {number}: the file does not begin with OFF")
    wide = 6 if words[0].upper().endswith(b"NOFF") else 3  # a normal beside each point
    number, words = (number, words[1:]) if len(words) > 1 else next(rows, (number, []))
    vertices, faces = (_count(number, words[k : k + 1]) for k in range(2))
    for k in range(vertices):
        number, words = rows.take(k, vertices, "vertex")
        if len(words) < wide:
            needed = "six" if wide == 6 else "three"
            raise _Fault(f"line {number}: {len(words)} numbers where {needed} are needed")
        if thorough:
            _numbers(number, words[:wide])
    for k in range(faces):
        number, words = rows.take(k, faces, "face")
        size = _integer(number, words[:1], "the number of corners")
        if len(words) < 1 + size:
            raise _Fault(f"line {number}: {len(words)} numbers where {1 + size} are needed")
        if thorough:
            _check_face((number, words), words[1 : 1 + size], vertices)


def _obj(content: bytes, thorough: bool) -> None:
    if not thorough:
        return
    rows = list(_Rows(content, 1, comments=True))
    vertices = sum(words[0] == b"v" for _, words in rows)
    for number, (word, *values) in rows:
        if word not in (b"v", b"vn", b"f"):
            continue
        if word == b"f":
            values = [value.partition(b"/")[0] for value in values]
            corners = [_integer(number, [value], "a vertex") for value in values]
            for corner in corners:
                if not 1 <= abs(corner) <= vertices:
                    raise _Fault(f"line {number}: vertex {corner} of {vertices}, counted from 1")
        else:
            _numbers(number, values)
        if len(values) < 3:
            raise _Fault(f"line {number}: {len(values)} numbers where three are needed")


class _Rows(Iterator[Line]):
    """Lines with words on them; `first` is the number of the first line."""

    def __init__(self, content: bytes, first: int, comments: bool) -> None:
        self._lines, self._comments = enumerate(content.splitlines(), first), comments
        self._last = first - 1

    def __next__(self) -> Line:
        for number, line in self._lines:
            words = (line.partition(b"#")[0] if self._comments else line).split()
            self._last = number
            if words:
                return number, words
        raise StopIteration

    def take(self, k: int, count: int, name: str) -> Line:
        """The next line, of row k of `count`."""
        row = next(self, None)
        if row is None:
            raise _Fault(f"line {self._last} is the last: {k} rows of kind {name!r} where {count} should be")
        return row


def _check_face(row: Line, corners: list[bytes], vertices: int) -> None:
    for corner in corners:
        index = _integer(row[0], [corner], "a vertex")
        if not 0 <= index < vertices:
            raise _Fault(f"line {row[0]}: vertex {index} of {vertices}, counted from 0")


def _integer(number: int, words: list[bytes], what: str) -> int:
    """The one word as a whole number."""
    try:
        return int(words[0])
    except (ValueError, IndexError):
        raise _Fault(f"line {number}: {_text(words)!r} where {what} should be") from None


def _count(number: int, words: list[bytes]) -> int:
    """The one word as a number of rows."""
    count = _integer(number, words, "a count")
    if count < 0:
        raise _Fault(f"line {number}: {count} where a count should be")
    return count


def _numbers(number: int, words: list[bytes]) -> None:
    """Raise unless all words are finite numbers."""
    for word in words:
        try:
            value = float(word)
        except ValueError:
            raise _Fault(f"line {number}: {_text([word])!r} where a number should be") from None
        if not math.isfinite(value):
            raise _Fault(f"line {number} has a number that is NaN or infinite")


def _text(words: list[bytes]) -> str:
    """Words as text, the first characters of them."""
    return b" ".join(words).decode(errors="replace")[:40]

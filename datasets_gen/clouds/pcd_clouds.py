"""Point clouds of the Point Cloud Library: PCD in text, binary and compressed."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from datasets_gen.clouds.column_names import NORMAL, POINT, as_names
from datasets_gen.clouds.point_cloud import PointCloud, counted
from datasets_gen.compiled import compiled

TYPES = {
    "F4": "f4",
    "F8": "f8",
    **{f"{sign}{n}": f"{sign.lower()}{n}" for sign in "IU" for n in (1, 2, 4, 8)},
}
IDENTITY = ["0", "0", "0", "1", "0", "0", "0"]
LARGEST = 1 << 31
"""Bytes of data after decompression."""


class PcdField(NamedTuple):
    """A column of a PCD file, or several beside each other (width)."""

    name: str
    kind: str
    width: int


def read_pcd(content: bytes) -> PointCloud:
    """Read a PCD file.

    Points of organised clouds that were not measured are NaN and left to be dropped. The pose of the sensor
    (VIEWPOINT) is not used.

    Raises
    ------
    ValueError
        If the file is not as its header says.
    """
    header, body = _header(content)
    fields, points = _fields(header), int(_first(header, "POINTS", "-1"))
    if points < 0:
        points = int(_first(header, "WIDTH", "0")) * int(_first(header, "HEIGHT", "1"))
    if not 0 <= points <= LARGEST:
        raise ValueError(f"{points} points")
    across = int(_first(header, "WIDTH", str(points))) * int(_first(header, "HEIGHT", "1"))
    if across != points:
        raise ValueError(f"POINTS {points}, but WIDTH x HEIGHT is {across}")
    storage = _first(header, "DATA", "").lower()
    if storage == "ascii":
        columns, left = _ascii(body, fields, points, content[: len(content) - len(body)].count(b"\n") + 1)
    elif storage in ("binary", "binary_compressed"):
        columns, left = _binary(body, fields, points, storage == "binary_compressed")
    else:
        raise ValueError(f"DATA {storage!r}; there are ascii, binary and binary_compressed")
    lacking = [name for name in POINT if name not in columns]
    if lacking:
        raise ValueError(f"no field {lacking[0]!r} in FIELDS {' '.join(f.name for f in fields)}")
    xyz = np.column_stack([columns[name] for name in POINT])
    normals = [columns[name] for name in NORMAL if name in columns]
    found = PointCloud(xyz, np.column_stack(normals) if len(normals) == 3 else None)
    moved = header.get("VIEWPOINT", IDENTITY) != IDENTITY
    return found.remarked(
        "the pose of the sensor (VIEWPOINT) is not used" if moved else "",
        f"{counted(left, 'byte')} after the last point are not used" if left else "",
    )


def _header(content: bytes) -> tuple[dict[str, list[str]], bytes]:
    """Words by key, and the data."""
    header: dict[str, list[str]] = {}
    place = 0
    while "DATA" not in header:
        line, end, _ = content[place : place + 4096].partition(b"\n")
        words = line.decode("latin-1").split()
        if words and not words[0].startswith("#"):
            header[words[0].upper()] = words[1:]
        place += len(line) + 1
        if not end:
            break
    if "DATA" not in header or "FIELDS" not in header:
        raise ValueError("no header with FIELDS and DATA")
    return header, content[place:]


def _first(header: dict[str, list[str]], key: str, otherwise: str) -> str:
    return (header.get(key) or [otherwise])[0]


def _fields(header: dict[str, list[str]]) -> list[PcdField]:
    names = header["FIELDS"]
    sizes, kinds = header.get("SIZE", ["4"] * len(names)), header.get("TYPE", ["F"] * len(names))
    counts = header.get("COUNT", ["1"] * len(names))
    if not len(names) == len(sizes) == len(kinds) == len(counts):
        raise ValueError("FIELDS, SIZE, TYPE and COUNT differ in number")
    out = list[PcdField]()
    for name, size, kind, count in zip(names, sizes, kinds, counts, strict=True):
        if kind + size not in TYPES or not 0 <= int(count) <= 10_000:
            raise ValueError(f"field {name!r} has type {kind}, size {size} and count {count}")
        meaning = (as_names([name, "x"]) or [name])[0]
        if meaning in (*POINT, *NORMAL) and any(each.name == meaning for each in out):
            raise ValueError(f"FIELDS names {name!r} twice")
        out.append(PcdField(meaning, TYPES[kind + size], int(count)))
    return out


def _ascii(
    body: bytes, fields: list[PcdField], points: int, first: int
) -> tuple[dict[str, NDArray[np.float64]], int]:
    """Columns of data in text, which begins at a line, and the number of bytes after them."""
    lines = enumerate(map(bytes.split, body.splitlines()), first)
    numbered = [(number, words) for number, words in lines if words]
    rows = [words for _, words in numbered]
    width = sum(each.width for each in fields)
    if len(rows) < points:
        raise ValueError(f"{len(rows)} points where {points} should be")
    wrong = next((each for each in numbered[:points] if len(each[1]) != width), None)
    if wrong is not None:
        raise ValueError(f"line {wrong[0]}: {len(wrong[1])} numbers where {width} should be")
    out, place = {}, 0
    for each in fields:
        if each.width == 1 and each.name in (*POINT, *NORMAL):
            out[each.name] = np.array([_number(row[place], line) for line, row in numbered[:points]], float)
        place += each.width
    return out, sum(len(word) for row in rows[points:] for word in row)


def _number(word: bytes, line: int) -> float:
    try:
        return float(word)
    except ValueError:
        said = word[:40].decode("latin-1")
        raise ValueError(f"line {line}: {said!r} where a number should be") from None


def _binary(
    body: bytes, fields: list[PcdField], points: int, packed: bool
) -> tuple[dict[str, NDArray[np.float64]], int]:
    """Columns of binary data: point by point, or packed column by column."""
    sizes = [np.dtype(each.kind).itemsize * each.width for each in fields]
    whole, left = sum(sizes) * points, 0
    if packed:
        inside = int.from_bytes(body[:4], "little")
        unpacked = int.from_bytes(body[4:8], "little")
        if len(body) < 8 + inside or unpacked < whole or unpacked > max(LARGEST, whole):
            raise ValueError(
                f"{unpacked} bytes of points, packed as {len(body) - 8}, where {whole} should be"
            )
        left, body = len(body) - 8 - inside, _unpacked(body[8 : 8 + inside], unpacked)
    elif len(body) < whole:
        raise ValueError(f"{len(body)} bytes of points where {whole} should be")
    else:
        left = len(body) - whole
    out, place = {}, 0
    for each, size in zip(fields, sizes, strict=True):
        if each.width == 1 and each.name in (*POINT, *NORMAL):
            start, step = (place * points, size) if packed else (place, sum(sizes))
            column: Any = (
                np.ndarray((points,), "<" + each.kind, body, start, (step,)) if points else np.zeros(0)
            )
            out[each.name] = column.astype(np.float64)
        place += size
    return out, left


def _unpacked(data: bytes, size: int) -> bytes:
    """What LZF has packed (Lehmann, liblzf)."""
    if size > 300 * len(data) + 300:  # its longest copy is of 264 bytes, in three
        raise ValueError(f"{size} bytes cannot come of {len(data)}")
    out = np.zeros(size, dtype=np.uint8)
    if _lzf(np.frombuffer(data, np.uint8), out) != size:
        raise ValueError("the compressed points are damaged")
    return out.tobytes()


@compiled()
def _lzf(data: Any, out: Any) -> int:
    """Unpack into `out`; gives the number of bytes, -1 for damaged data."""
    i = o = 0
    n, room = len(data), len(out)
    while i < n:
        control = int(data[i])
        i += 1
        if control < 32:  # literal bytes
            count = control + 1
            if i + count > n or o + count > room:
                return -1
            for k in range(count):
                out[o + k] = data[i + k]
            i, o = i + count, o + count
            continue
        length = control >> 5  # a copy of earlier bytes
        if length == 7:
            if i >= n:
                return -1
            length += int(data[i])
            i += 1
        if i >= n:
            return -1
        start = o - ((control & 31) << 8) - int(data[i]) - 1
        i += 1
        if start < 0 or o + length + 2 > room:
            return -1
        for k in range(length + 2):
            out[o + k] = out[start + k]
        o += length + 2
    return o

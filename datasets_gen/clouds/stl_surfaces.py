"""Triangles of an STL file, ascii or binary. It repeats every corner: equal ones become one vertex."""

import re
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from datasets_gen.clouds.point_cloud import PointCloud, counted
from datasets_gen.meshes.geometry import first_at_places

FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
TEXT = re.compile(rb"[\r\n]\s*(facet\s+normal|endsolid)", re.IGNORECASE)
"""In a file that begins with ``solid``, which binary ones may do, too."""
HEADER = 84
"""Bytes before the facets of a binary file: a title and their number."""


def read_stl(content: bytes) -> PointCloud:
    """Read an STL file.

    Raises
    ------
    ValueError
        If it is cut short, or no STL file.
    """
    count = int.from_bytes(content[80:HEADER], "little") if len(content) >= HEADER else 0
    end = HEADER + count * FACET.itemsize
    text = content[:200].lstrip()[:5].lower() == b"solid" and TEXT.search(content) is not None
    if text and len(content) != end:
        return _text(content)
    if len(content) < HEADER:
        raise ValueError(
            f"{len(content)} bytes: no facets in text, and shorter than the header of a binary file"
        )
    if len(content) < end:
        there = max(0, len(content) - HEADER) // FACET.itemsize
        raise ValueError(f"{there} facets where {count} should be")
    corners = np.frombuffer(content, FACET, count, HEADER)["corners"].astype(np.float64)
    left = len(content) - end
    remark = f"{counted(left, 'byte')} after the last facet are not used" if left else ""
    return welded(corners.reshape(-1, 3), "STL repeats the corners of each face").remarked(remark)


def _text(content: bytes) -> PointCloud:
    """Facets in text; several solids are one mesh."""
    lines = [(number, line.split()) for number, line in enumerate(content.splitlines(), 1)]
    kinds = [(number, words[0].lower(), words[1:]) for number, words in lines if words]
    rows = [finite_numbers(words, number) for number, kind, words in kinds if kind == b"vertex"]
    facets = sum(kind == b"facet" for _, kind, _ in kinds)
    if len(rows) != 3 * facets:
        raise ValueError(f"{len(rows)} corners for {facets} facets")
    points = np.array(rows, dtype=np.float64).reshape(-1, 3)
    if b"endsolid" not in content.lower():
        raise ValueError("no line 'endsolid' at the end")
    return welded(points, "STL repeats the corners of each face")


def finite_numbers(words: list[bytes], line: int) -> list[float]:
    """The first three words of a line as numbers.

    Raises
    ------
    ValueError
        With the line, if there are fewer, or one is no finite number.
    """
    if len(words) < 3:
        raise ValueError(f"line {line}: {len(words)} numbers where three are needed")
    for word in words[:3]:
        try:
            finite = isfinite(float(word))
        except ValueError:
            finite = False
        if not finite:
            raise ValueError(f"line {line}: {word[:40].decode(errors='replace')!r} where a number should be")
    return [float(word) for word in words[:3]]


def welded(corners: NDArray[np.float64], why: str, faces: NDArray[np.int64] | None = None) -> PointCloud:
    """A mesh whose vertices are the distinct places of others, in the order in which they first occur.

    Parameters
    ----------
    corners : (c, 3)
    why
        They repeat; for the remark.
    faces : (f, 3), optional
        Of the corners; three of them each by default.
    """
    faces = np.arange(len(corners)).reshape(-1, 3) if faces is None else faces
    kept, place = first_at_places(corners)
    found = PointCloud(corners[kept], None, (), place[faces])
    if len(found) == len(corners):
        return found
    return found.remarked(f"{why}: {len(corners):,} welded to {counted(len(found), 'vertex', 'vertices')}")

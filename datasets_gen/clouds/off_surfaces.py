"""Points, normals and triangles of an OFF file with any letters before ``OFF``."""

import re

import numpy as np

from datasets_gen.clouds.point_cloud import PointCloud, counted
from datasets_gen.clouds.polygons import said_of_small, triangles_of

KIND = re.compile(rb"(ST)?(C)?(N)?OFF", re.IGNORECASE)
"""Texture coordinates come last in a row, colours before them, normals right after the point."""


def read_off(content: bytes) -> PointCloud:
    """Read an OFF file in text: OFF, NOFF (normals), COFF (colours), STOFF (texture) and their combinations.

    Rows may have colours, counts may stand beside the first word, and ``#`` begins a comment. Normals of NOFF
    are kept.

    Raises
    ------
    ValueError
        If the file is not as its first lines say.
    """
    lines = (line.partition(b"#")[0].split() for line in content.removeprefix(b"\xef\xbb\xbf").splitlines())
    rows = [words for words in lines if words]
    kind = KIND.fullmatch(rows[0][0]) if rows else None
    if kind is None:
        raise ValueError("the file does not begin with OFF, NOFF, COFF, CNOFF or STOFF")
    if rows[0][1:2] and rows[0][1].upper() == b"BINARY":
        raise ValueError("binary OFF; write it in text, or as PLY")
    counts, rows = (rows[0][1:], rows[1:]) if len(rows[0]) > 1 else (rows[1] if rows[1:] else [], rows[2:])
    if len(counts) < 2:
        raise ValueError("no line with the numbers of vertices and faces")
    points, faces = int(counts[0]), int(counts[1])
    if min(points, faces) < 0 or len(rows) < points + faces:
        raise ValueError(f"{len(rows)} rows where {points} vertices and {faces} faces should be")
    wide = 6 if kind[3] else 3
    table = np.array([row[:wide] for row in rows[:points]]).astype(np.float64).reshape(-1, wide)
    polygons = rows[points : points + faces]
    lengths = np.array([int(row[0]) for row in polygons], dtype=np.int64)
    corners = [row[1 : 1 + n] for row, n in zip(polygons, lengths, strict=True)]
    if any(n < 0 or len(row) != n for row, n in zip(corners, lengths, strict=True)):
        raise ValueError("a face with fewer corners than it says")
    ids = np.array([int(word) for row in corners for word in row], dtype=np.int64)
    left = len(rows) - points - faces - (int(counts[2]) if counts[2:3] and counts[2].isdigit() else 0)
    found = PointCloud(
        np.ascontiguousarray(table[:, :3]),
        np.ascontiguousarray(table[:, 3:]) if kind[3] else None,
        faces=triangles_of(lengths, ids) if faces else None,
    )
    unused = f"{counted(left, 'line')} after the last face are not used" if left > 0 else ""
    return found.remarked(unused, said_of_small(lengths))

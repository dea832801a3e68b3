"""Points, normals and triangles of an OBJ file, without its materials, objects and groups."""

from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.clouds.point_cloud import PointCloud
from datasets_gen.clouds.polygons import said_of_small

Line = tuple[int, list[bytes]]
"""Number of a line, counted from 1, and the words after its first."""


def read_obj(content: bytes) -> PointCloud:
    """Read an OBJ file: vertices and faces in the order of the file.

    Normals are those of a cloud, one line ``vn`` for each ``v``; those of a mesh belong to corners of its
    faces, and the faces tell them. Colours beside the coordinates of vertices are not used.

    Raises
    ------
    ValueError
        If a line is wrong.
    """
    lines, faces, lengths = _lines(content), list[bytes](), list[int]()
    for before, number, words in lines["f"]:
        corners = [_corner(word, before, len(lines["v"]), number) for word in words]
        faces.append(b"f " + b" ".join(b"%d" % corner for corner in corners))
        lengths.append(len(corners))
    points = _vectors([(number, words) for _, number, words in lines["v"]])
    if not faces:
        normals = _vectors([(number, words) for _, number, words in lines["vn"]])
        if len(normals) in (0, len(points)):
            return PointCloud(points, normals if len(normals) else None)
        return PointCloud(points).remarked(f"{len(normals)} normals for {len(points)} points: not used")
    return PointCloud(points, None, (), _triangles(len(points), faces)).remarked(
        said_of_small(np.array(lengths))
    )


def _lines(content: bytes) -> dict[str, list[tuple[int, int, list[bytes]]]]:
    """Lines ``v``, ``vn`` and ``f``: the vertices before each, its number and its words; no comments.

    A backslash at the end of a line goes on in the next.
    """
    found: dict[str, list[tuple[int, int, list[bytes]]]] = {"v": [], "vn": [], "f": []}
    kinds = {b"v": found["v"], b"vn": found["vn"], b"f": found["f"]}
    begun = list[bytes]()
    for number, line in enumerate(content.removeprefix(b"\xef\xbb\xbf").splitlines(), 1):
        text = line.partition(b"#")[0].rstrip()
        words = begun + text.removesuffix(b"\\").split()
        if text.endswith(b"\\"):
            begun = words
            continue
        begun = []
        if words and words[0] in kinds:
            kinds[words[0]].append((len(found["v"]), number, words[1:]))
    return found


def _corner(word: bytes, before: int, count: int, line: int) -> int:
    """The vertex that a corner such as ``7``, ``7/1``, ``7//3`` or ``-2`` names, counted from 1.

    A negative one counts backwards from the last vertex before the face.
    """
    index = int(word.partition(b"/")[0])
    if not index or index > count:
        raise ValueError(f"line {line}: vertex {index} of {count}, counted from 1")
    if index < -before:
        raise ValueError(f"line {line}: vertex {index}, counted backwards from {before} before it")
    return index if index > 0 else before + 1 + index


def _vectors(lines: list[Line]) -> NDArray[np.float64]:
    """The first three numbers of all lines of one kind."""
    short = next(((number, words) for number, words in lines if len(words) < 3), None)
    if short is not None:
        raise ValueError(f"line {short[0]}: {len(short[1])} numbers where three are needed")
    return np.array([[float(word) for word in words[:3]] for _, words in lines], np.float64).reshape(-1, 3)


def _triangles(count: int, faces: list[bytes]) -> NDArray[np.int64]:
    """Triangles of polygons in the order of trimesh, which earlier versions have stored.

    It is given plain lines: of its own it takes no tabs, comments, blanks at the start or letters that are no
    UTF-8, makes a mesh of each group, and knows no negative index.
    """
    import trimesh  # in the functions that need it: a start without it takes half as long

    text = b"v 0 0 0\n" * count + b"\n".join(faces) + b"\n"
    mesh: Any = trimesh.load(BytesIO(text), file_type="obj", process=False, maintain_order=True)
    return np.array(getattr(mesh, "faces", ()), dtype=np.int64).reshape(-1, 3)

"""Points, normals and triangles of an OBJ file, without its materials, objects and groups."""

from collections.abc import Iterator
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.clouds.point_cloud import PointCloud

OBJ_PARTITIONS = (b"mtllib", b"usemtl", b"o ", b"g ", b"s ", b"o\t", b"g\t")


def read_obj(content: bytes) -> PointCloud:
    """Read an OBJ file: vertices and faces in the order of the file.

    Normals are those of a cloud, one line ``vn`` for each ``v``; those of a mesh belong to corners of its
    faces, and the faces tell them. Colours beside the coordinates of vertices are not used.

    Raises
    ------
    ValueError
        If a line is wrong, or there are no vertices.
    """
    lines = content.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").removeprefix(b"\xef\xbb\xbf").splitlines()
    points = _vectors(lines, (b"v ", b"v\t"))
    if not any(line.startswith((b"f ", b"f\t")) for line in lines):
        normals = _vectors(lines, (b"vn ", b"vn\t"))
        if len(normals) in (0, len(points)):
            return PointCloud(points, normals if len(normals) else None)
        return PointCloud(points).remarked(f"{len(normals)} normals for {len(points)} points: not used")
    import trimesh  # in the functions that need it: a start without it takes half as long

    text = b"\n".join(_bare(lines))
    mesh: Any = trimesh.load(BytesIO(text), file_type="obj", process=False, maintain_order=True)
    vertices = np.array(mesh.vertices, dtype=np.float64)
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise ValueError(f"vertices of shape {vertices.shape}, not (v, 3)")
    return PointCloud(vertices, None, (), np.array(mesh.faces, dtype=np.int64).reshape(-1, 3))


def _vectors(lines: list[bytes], starts: tuple[bytes, ...]) -> NDArray[np.float64]:
    """The first three numbers of all lines of one kind."""
    rows = [line.split()[1:4] for line in lines if line.startswith(starts)]
    if any(len(row) < 3 for row in rows):
        raise ValueError("a line with fewer than three numbers")
    return np.array([[float(word) for word in row] for row in rows], dtype=np.float64).reshape(-1, 3)


def _bare(lines: list[bytes]) -> Iterator[bytes]:
    """Lines of an OBJ without materials, objects and groups; its faces name vertices alone, counted from 1.

    trimesh would make a mesh of each group, in another order. A negative index counts backwards from the last
    vertex before the face; trimesh knows none.
    """
    count = 0
    for line in lines:
        if line.startswith((b"v ", b"v\t")):
            count += 1
        if line.startswith((b"f ", b"f\t")) and b"-" in line:
            corners = [int(corner.partition(b"/")[0]) for corner in line.split()[1:]]
            yield b"f " + b" ".join(b"%d" % (c if c > 0 else count + 1 + c) for c in corners)
        elif not line.startswith(OBJ_PARTITIONS):
            yield line

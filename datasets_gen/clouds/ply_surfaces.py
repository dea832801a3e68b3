"""Points, normals and triangles of a PLY file; strips of triangles, too."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.clouds.ply_elements import ListColumn, PlyElement, read_elements
from datasets_gen.clouds.point_cloud import PointCloud, counted
from datasets_gen.clouds.polygons import said_of_small, triangles_of

FACES = ("vertex_indices", "vertex_index")
NORMALS = (("nx", "ny", "nz"), ("normal_x", "normal_y", "normal_z"), ("normalx", "normaly", "normalz"))


def read_ply(content: bytes) -> PointCloud:
    """Read a PLY file.

    Bytes after the last element, as some exporters leave, are a remark. Polygons are cut in the order of the
    file; so are strips.

    Raises
    ------
    ValueError
        If the file is not as its header says, or has no points.
    """
    elements, left = read_elements(content)
    vertex = elements.get("vertex")
    if vertex is None:
        raise ValueError("no element 'vertex'")
    points = _columns(vertex, ("x", "y", "z"))
    if points is None:
        lacking = next(each for each in "xyz" if each not in vertex.columns)
        raise ValueError(f"the header names no property {lacking!r} of vertices")
    normals = next((n for n in (_columns(vertex, names) for names in NORMALS) if n is not None), None)
    polygons = _lists(elements.get("face"), FACES)
    faces = [_strips(elements.get("tristrips"))]
    faces += [] if polygons is None else [triangles_of(*polygons)]
    found = [each for each in faces if each is not None and len(each)]
    remark = f"{counted(left, 'byte')} after the last element are not used" if left else ""
    whole = np.concatenate(found) if found else None
    return PointCloud(points, normals, (), whole).remarked(
        remark, "" if polygons is None else said_of_small(polygons.lengths)
    )


def _columns(element: PlyElement, names: tuple[str, ...]) -> NDArray[np.float64] | None:
    """Columns of numbers side by side, (n, k); None if one is missing."""
    arrays = [element.columns.get(name) for name in names]
    if any(array is None or isinstance(array, ListColumn) for array in arrays):
        return None
    return np.column_stack(arrays).astype(np.float64).reshape(-1, len(names))  # type: ignore[arg-type]


def _lists(element: PlyElement | None, names: tuple[str, ...]) -> ListColumn | None:
    """The property of an element that holds indices of vertices."""
    found: Any = None
    if element is not None:
        found = next((element.columns[name] for name in names if name in element.columns), None)
        lists = [each for each in element.columns.values() if isinstance(each, ListColumn)]
        if found is None and len(lists) == 1 and len(element.columns) == 1:
            found = lists[0]
    if element is not None and element.count and not isinstance(found, ListColumn):
        raise ValueError(f"element {element.name!r} has no list {names[0]!r}")
    return found if isinstance(found, ListColumn) else None


def _strips(element: PlyElement | None) -> NDArray[np.int64] | None:
    """Triangles of strips, which -1 ends; every second one is turned, so that all have one winding."""
    lists = _lists(element, FACES)
    if lists is None:
        return None
    ends = np.cumsum(lists.lengths)[:-1]
    out = [np.zeros((0, 3), np.int64)]
    for row in np.split(lists.values.astype(np.int64), ends):
        for strip in np.split(row, np.flatnonzero(row < 0)):
            strip = strip[strip >= 0]
            if len(strip) < 3:
                continue
            found = np.column_stack([strip[:-2], strip[1:-1], strip[2:]])
            found[1::2] = found[1::2, [1, 0, 2]]
            solid = (found != np.roll(found, 1, axis=1)).all(axis=1)  # repeated ids only join two strips
            out.append(found[solid])
    return np.concatenate(out)

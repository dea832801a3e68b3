"""Polygons cut into triangles, always alike: poses with the same polygons keep the same triangles."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.clouds.point_cloud import counted


def triangles_of(lengths: NDArray[np.int64], corners: NDArray[Any]) -> NDArray[np.int64]:
    """Triangles of polygons; triangles come first, then the halves of quadrilaterals, then fans of the rest.

    That is the order of trimesh, by which meshes of other formats are read.

    Parameters
    ----------
    lengths : (p,)
        Number of corners of each polygon.
    corners : (sum of lengths,)
        Ids of vertices.

    Returns
    -------
    (f, 3) int64
        Without those of fewer than three corners.
    """
    from trimesh.geometry import triangulate_quads  # where it is needed: a start without it is faster

    ids, large = np.asarray(corners).astype(np.int64), lengths > 2
    if not large.all():
        ids, lengths = ids[np.repeat(large, lengths)], lengths[large]
    if not len(lengths):
        return np.zeros((0, 3), np.int64)
    alike = bool((lengths == lengths[0]).all()) and lengths[0] <= 4
    polygons: Any = ids.reshape(len(lengths), -1) if alike else np.split(ids, np.cumsum(lengths)[:-1])
    return np.asarray(triangulate_quads(polygons), dtype=np.int64).reshape(-1, 3)


def said_of_small(lengths: NDArray[np.int64]) -> str:
    """A remark on polygons of one or two corners; empty if there are none."""
    small = int((lengths < 3).sum())
    return f"{counted(small, 'face')} of fewer than three corners left out" if small else ""

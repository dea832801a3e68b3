"""Mirror images of surface points, for the symmetry-aware error."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.meshes.nearest_faces import closest_barycentrics
from datasets_gen.shape import Shape
from evaluation.metrics.correspondence import SurfacePoints


def mirror_points(shape: Shape, mirror: NDArray[np.int64], points: SurfacePoints) -> SurfacePoints:
    """Carry surface points to the other side of a symmetric shape.

    The corners' mirror vertices, weighted by the barycentrics, give a position; the closest point of the
    faces around those vertices is the mirror image. Exact where the mesh is symmetric itself.

    Parameters
    ----------
    shape
        The pose in which `mirror` was found: the reference.
    mirror : (v,)
        Vertex that mirrors each vertex.
    points

    Returns
    -------
    SurfacePoints
    """
    corners = mirror[shape.faces[points.face_ids]]  # (n, 3)
    wanted = np.einsum("nc,ncd->nd", points.barycentrics, shape.vertices[corners])
    around = _faces_of_vertices(shape)[corners].reshape(len(points), -1)  # (n, candidates), padded with -1
    rows, columns = np.nonzero(around >= 0)
    faces = around[rows, columns]
    weights = closest_barycentrics(shape.vertices[shape.faces[faces]], wanted[rows])
    gaps = np.linalg.norm(shape.at(faces, weights) - wanted[rows], axis=1)
    order = np.lexsort((gaps, rows))  # nan, of faces without area, comes last
    best = order[np.searchsorted(rows[order], np.arange(len(points)))]
    return SurfacePoints(faces[best], weights[best])


def _faces_of_vertices(shape: Shape) -> NDArray[np.int64]:
    """Faces around each vertex, (v, largest number of them), padded with -1."""
    vertex = shape.faces.ravel()
    order = np.argsort(vertex, kind="stable")
    counts = np.bincount(vertex, minlength=len(shape.vertices))
    place = np.arange(len(vertex)) - np.repeat(np.cumsum(counts) - counts, counts)
    table = np.full((len(shape.vertices), counts.max()), -1, dtype=np.int64)
    table[vertex[order], place] = order // 3
    return table

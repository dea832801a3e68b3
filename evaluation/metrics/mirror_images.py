"""Mirror images of surface points, for the symmetry-aware error."""

import numpy as np
from numpy.typing import NDArray

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
    order = np.lexsort((gaps, rows))
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


def closest_barycentrics(triangles: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Barycentrics of the point of each triangle that is closest to each point.

    Parameters
    ----------
    triangles : (n, 3, 3)
    points : (n, 3)

    Returns
    -------
    (n, 3) float64
        In [0, 1], summing to 1.
    """
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    candidates = [_plane_barycentrics(a, b, c, points)]
    for first, second in ((0, 1), (1, 2), (2, 0)):
        start, end = triangles[:, first], triangles[:, second]
        edge = end - start
        length = np.maximum(np.einsum("nd,nd->n", edge, edge), np.finfo(float).tiny)
        along = np.clip(np.einsum("nd,nd->n", points - start, edge) / length, 0, 1)
        weights = np.zeros((len(points), 3))
        weights[:, first], weights[:, second] = 1 - along, along
        candidates.append(weights)
    stacked = np.stack(candidates)  # (4, n, 3)
    gaps = np.linalg.norm(np.einsum("knc,ncd->knd", stacked, triangles) - points, axis=2)
    gaps[(stacked < 0).any(axis=2)] = np.inf
    return stacked[gaps.argmin(axis=0), np.arange(len(points))]


def _plane_barycentrics(
    a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Barycentrics of the projections to the triangles' planes, (n, 3); negative outside."""
    u, v, w = b - a, c - a, points - a
    uu, uv, vv = (np.einsum("nd,nd->n", p, q) for p, q in ((u, u), (u, v), (v, v)))
    wu, wv = np.einsum("nd,nd->n", w, u), np.einsum("nd,nd->n", w, v)
    scale = np.maximum(uu * vv - uv * uv, np.finfo(float).tiny)
    second, third = (vv * wu - uv * wv) / scale, (uu * wv - uv * wu) / scale
    return np.column_stack([1 - second - third, second, third])

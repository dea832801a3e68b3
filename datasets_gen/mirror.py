"""Left and right of a mesh, found from its geometry alone."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.shape import Shape

SYMMETRIC = 4e-3  # accepted distance of reflected points from the surface, per bounding-box diagonal
REFINEMENTS = 20
SAMPLES = 2000


def mirror_map(shape: Shape, tolerance: float = SYMMETRIC) -> NDArray[np.int64] | None:
    """Find the bilateral symmetry of a shape and the vertex that mirrors each vertex.

    Planes through the centroid across the coordinate and principal axes are refined by alternating between
    nearest points and the best reflection. The plane whose reflection stays closest to the surface wins.

    Parameters
    ----------
    shape
        Usually the reference pose.
    tolerance
        Largest 95th percentile of the distance between reflected vertices and the surface, in bounding-box
        diagonals.

    Returns
    -------
    (v,) int64 or None
        None where no plane reaches the tolerance. An involution up to the spacing of the vertices.
    """
    points, normals = shape.vertices, vertex_normals(shape)
    tree = cKDTree(points)
    scale = float(np.linalg.norm(np.ptp(points, axis=0)))
    weights = shape.face_areas
    centroid = np.average(points[shape.faces].mean(axis=1), axis=0, weights=weights)
    spread = np.cov((points[shape.faces].mean(axis=1) - centroid).T, aweights=weights)
    sample = np.unique(np.linspace(0, len(points) - 1, min(SAMPLES, len(points))).astype(np.int64))
    best, best_residual = None, tolerance * scale
    for axis in (*np.eye(3), *np.linalg.eigh(spread)[1].T):
        plane = _refined_plane(points[sample], tree, axis, centroid)
        image = reflect(points, *plane)
        nearest = tree.query(image)[1]
        off = np.abs(np.einsum("nd,nd->n", image - points[nearest], normals[nearest]))
        agrees = np.einsum("nd,nd->n", reflect(normals, plane[0], np.zeros(3)), normals[nearest])
        residual = float(np.quantile(np.where(agrees > 0, off, scale), 0.95))
        if residual < 0.95 * best_residual:  # a tie, as on a sphere, goes to the earlier axis
            best, best_residual = nearest.astype(np.int64), residual
    return best


def reflect(
    points: NDArray[np.float64], normal: NDArray[np.float64], origin: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Mirror images of points (n, 3) in the plane through `origin` (3,) across the unit `normal` (3,)."""
    return points - 2 * ((points - origin) @ normal)[:, None] * normal


def best_reflection(
    points: NDArray[np.float64], images: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The plane whose reflection takes points (n, 3) closest to images (n, 3), in least squares.

    With u, v the two sets about the mean of all midpoints, |v - u + 2 (u.n) n|^2 differs from |v - u|^2 by
    4 (u.n)(v.n), so n is the lowest eigenvector of the symmetric part of sum u v^T.

    Returns
    -------
    normal (3,), origin (3,)
    """
    origin = (points.mean(axis=0) + images.mean(axis=0)) / 2
    moment = (points - origin).T @ (images - origin)
    return np.linalg.eigh(moment + moment.T)[1][:, 0], origin


def _refined_plane(
    points: NDArray[np.float64], tree: cKDTree, normal: NDArray[np.float64], origin: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    for _ in range(REFINEMENTS):
        images = tree.data[tree.query(reflect(points, normal, origin))[1]]
        normal, origin = best_reflection(points, images)
    return normal, origin


def vertex_normals(shape: Shape) -> NDArray[np.float64]:
    """Area-weighted unit normals of the vertices, (v, 3); zero for a vertex without faces."""
    a, b, c = (shape.vertices[shape.faces[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    total = np.zeros_like(shape.vertices)
    for k in range(3):
        np.add.at(total, shape.faces[:, k], cross)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.divide(total, length, out=np.zeros_like(total), where=length > 0)

"""The points of a triangle mesh that are closest to given points, as faces and barycentric coordinates."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

CANDIDATES = 32
"""Faces, by their centroids, among which the closest point is looked for."""


def closest_barycentrics(triangles: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Barycentrics of the point of each triangle that is closest to each point.

    Parameters
    ----------
    triangles : (n, 3, 3)
        Corners.
    points : (n, 3)

    Returns
    -------
    (n, 3) float64
        In [0, 1], summing to 1; nan where a triangle has no area.
    """
    from trimesh.triangles import closest_point, points_to_barycentric  # a third of a second to import

    closest = closest_point(triangles, points)
    with np.errstate(invalid="ignore", divide="ignore"):
        weights = np.clip(points_to_barycentric(triangles, closest, method="cross"), 0, 1)  # rounding
        return weights / weights.sum(axis=1, keepdims=True)


def nearest_on_mesh(
    vertices: NDArray[np.float64], faces: NDArray[np.integer], points: NDArray[np.float64]
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """The closest surface point of each point, among the `CANDIDATES` faces of nearest centroids.

    Exact for points near a mesh whose faces are of like size, as those that are interpolated between points
    of it.

    Parameters
    ----------
    vertices : (v, 3)
    faces : (f, 3)
    points : (n, 3)
        Finite.

    Returns
    -------
    face_ids : (n,) int32
    barycentrics : (n, 3) float64
    """
    if not len(points):
        return np.empty(0, dtype=np.int32), np.empty((0, 3))
    k = min(CANDIDATES, len(faces))
    corners = vertices[faces]
    around = cKDTree(corners.mean(axis=1)).query(points, k)[1].reshape(len(points), k)
    weights = closest_barycentrics(corners[around.ravel()], np.repeat(points, k, axis=0)).reshape(-1, k, 3)
    places = np.einsum("nkc,nkcd->nkd", weights, corners[around])
    gaps = np.linalg.norm(places - points[:, None], axis=2)
    best = np.where(np.isnan(gaps), np.inf, gaps).argmin(axis=1)
    rows = np.arange(len(points))
    return around[rows, best].astype(np.int32), weights[rows, best]

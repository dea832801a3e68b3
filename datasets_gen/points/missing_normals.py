"""Normals of the few points of a cloud that have none, from those around them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.points.neighbours import query_tree

NEIGHBOURS = 12
"""Through which the plane of a point goes, and whose normals tell its side."""


def filled_normals(
    points: NDArray[np.float64], normals: NDArray[Any], lacking: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """The normals, with those that are lacking estimated.

    The axis is that of the plane through the nearest points, the side that of the normals of the nearest
    points that have one. Where the points around lie at one place or on a line, it is the mean of those
    normals.

    Parameters
    ----------
    points : (n, 3)
        Finite.
    normals : (n, 3)
    lacking : (n,) bool
        Not all of them.

    Returns
    -------
    (n, 3) float64
        Unit where they were lacking, as given elsewhere.
    """
    out = np.array(normals, dtype=np.float64)
    places, rows = points[lacking], np.flatnonzero(~lacking)
    count = min(NEIGHBOURS, len(rows))
    near = query_tree(cKDTree(points[rows]), places, k=count)[1].reshape(len(places), count)
    given = out[rows]
    given = given / np.linalg.norm(given, axis=1, keepdims=True)
    mean = given[near].sum(axis=1)
    around = query_tree(cKDTree(points), places, k=min(NEIGHBOURS + 1, len(points)))[1]
    cloud = points[around.reshape(len(places), -1)]
    cloud = cloud - cloud.mean(axis=1, keepdims=True)
    values, axes = np.linalg.eigh(np.einsum("mki,mkj->mij", cloud, cloud))
    axis = axes[:, :, 0]
    flat = values[:, 1] > 1e-9 * np.maximum(values[:, 2], 1e-300)
    nearest = np.where(np.linalg.norm(mean, axis=1, keepdims=True) > 1e-6, mean, given[near[:, 0]])
    axis = np.where(flat[:, None], axis, nearest)
    axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
    facing = np.einsum("nd,nd->n", axis, nearest)
    out[lacking] = np.where(facing[:, None] < 0, -axis, axis)
    return out

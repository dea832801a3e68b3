"""Derivatives of functions on a cloud, by local least squares."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree


def tangent_frames(normals: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Two unit vectors orthogonal to each normal, right-handed with it, (n, 3) each."""
    axis = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(axis, normals)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.cross(normals, first)


def gradients(
    points: NDArray[np.float64], normals: NDArray[np.float64], k: int = 10
) -> tuple[csr_array, csr_array]:
    """Derivatives of functions along the two directions of `tangent_frames`.

    Least squares over the nearest neighbours that face the same way, weighted by a Gaussian.

    Parameters
    ----------
    points, normals : (n, 3)
    k
        Neighbours.

    Returns
    -------
    csr_array (n, n), csr_array (n, n)
    """
    n = len(points)
    lengths, ids = cKDTree(points).query(points, k=min(k + 1, n))
    first, second = tangent_frames(normals)
    offset = points[ids] - points[:, None]  # (n, k, 3)
    u, v = np.einsum("nkd,nd->nk", offset, first), np.einsum("nkd,nd->nk", offset, second)
    facing = np.einsum("nkd,nd->nk", normals[ids], normals) > 0
    width = lengths[:, -1:] + np.finfo(float).tiny
    weight = np.exp(-((lengths / width) ** 2)) * facing
    weight[:, 0] = 0
    uu, uv, vv = (weight * u * u).sum(1), (weight * u * v).sum(1), (weight * v * v).sum(1)
    ridge = 1e-6 * (uu + vv) + np.finfo(float).tiny
    determinant = (uu + ridge) * (vv + ridge) - uv**2
    along_u = weight * ((vv + ridge)[:, None] * u - uv[:, None] * v) / determinant[:, None]
    along_v = weight * ((uu + ridge)[:, None] * v - uv[:, None] * u) / determinant[:, None]
    return _difference(ids, along_u), _difference(ids, along_v)


def _difference(ids: NDArray[np.int64], weights: NDArray[np.float64]) -> csr_array:
    """Operator sum_k w_k (f(neighbour k) - f(point))."""
    n, k = ids.shape
    rows = np.repeat(np.arange(n), k)
    matrix = csr_array((weights.ravel(), (rows, ids.ravel())), shape=(n, n))
    diagonal = csr_array((-weights.sum(axis=1), (np.arange(n), np.arange(n))), shape=(n, n))
    return csr_array(matrix + diagonal)

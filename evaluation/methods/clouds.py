"""Parts that several methods need: graphs and derivatives on clouds, nearest neighbours, confidence."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from datasets_gen.points.farthest import farthest_points
from datasets_gen.records import InputError


def require(count: int, least: int, method: str) -> None:
    """Raise unless a cloud has enough points for a method."""
    if count < least:
        raise InputError(f"{method} needs at least {least} points, got {count}; scan or keep more")


def typical_confidence(residual: NDArray[np.float64]) -> NDArray[np.float64]:
    """Residuals relative to their median, mapped to (0, 1]: 1 fits perfectly, 1/2 is typical."""
    typical = max(float(np.median(residual)), np.finfo(float).tiny)
    return 1 / (1 + residual / typical)


def neighbour_graph(points: NDArray[np.float64], k: int = 8) -> csr_array:
    """Symmetric graph of the k nearest neighbours, made connected.

    Components are joined to the largest one by the shortest edge between them, repeatedly: a scan's gaps must
    not make parts infinitely far.

    Parameters
    ----------
    points : (n, 3)
    k

    Returns
    -------
    csr_array (n, n)
        Euclidean edge lengths.
    """
    n = len(points)
    lengths, ids = cKDTree(points).query(points, k=min(k + 1, n))
    rows = np.repeat(np.arange(n), ids.shape[1] - 1)
    graph = csr_array((lengths[:, 1:].ravel(), (rows, ids[:, 1:].ravel())), shape=(n, n))
    graph = graph.maximum(graph.T)
    while True:
        count, label = connected_components(graph, directed=False)
        if count == 1:
            return csr_array(graph)
        main = label == np.bincount(label).argmax()
        inside, outside = np.flatnonzero(main), np.flatnonzero(~main)
        gaps, nearest = cKDTree(points[inside]).query(points[outside])
        bridges = []
        for other in np.unique(label[outside]):
            of = np.flatnonzero(label[outside] == other)
            best = of[gaps[of].argmin()]
            bridges.append((outside[best], inside[nearest[best]], gaps[best]))
        a, b, length = (np.array(column) for column in zip(*bridges, strict=True))
        length = np.maximum(length, np.finfo(float).tiny)
        both = (np.concatenate([a, b]), np.concatenate([b, a]))
        graph = graph + csr_array((np.concatenate([length, length]), both), shape=(n, n))


def far_landmarks(graph: csr_array, count: int, start: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Points far apart on a graph, and their distances to all points.

    The first is the point farthest from `start`: an extremity.

    Returns
    -------
    landmarks : (count,) int64
    distances : (count, n) float64
    """
    source = int(dijkstra(graph, indices=start).argmax())
    found, rows = [source], [dijkstra(graph, indices=source)]
    while len(found) < min(count, graph.shape[0]):
        source = int(np.min(rows, axis=0).argmax())
        found.append(source)
        rows.append(dijkstra(graph, indices=source))
    return np.array(found), np.array(rows)


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


def thinned(points: NDArray[np.float64], count: int, seed: int) -> NDArray[np.int64]:
    """Ids of farthest-point samples; all points if there are no more than `count`."""
    if len(points) <= count:
        return np.arange(len(points))
    start = int(np.random.default_rng(seed).integers(len(points)))
    return np.asarray(farthest_points(points, count, start), np.int64)

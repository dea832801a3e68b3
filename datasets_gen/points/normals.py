"""Normals estimated from points alone: PCA, with the sign from the scanner or from a spanning tree."""

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial import cKDTree

from datasets_gen.records import InputError


def pca(points: NDArray[np.float64], neighbours: int = 12) -> NDArray[np.float64]:
    """Unit normals by principal components of each point and its nearest neighbours; signs are arbitrary.

    Parameters
    ----------
    points : (n, 3)
    neighbours
        Number of neighbours, the point itself not counted.

    Returns
    -------
    (n, 3) float64

    Raises
    ------
    InputError
        If there are not more points than neighbours.
    """
    index = _nearest(points, neighbours)
    out = np.empty_like(points)
    for part in np.array_split(np.arange(len(points)), max(1, len(points) // 100_000)):
        cloud = points[index[part]]  # (m, k, 3)
        cloud = cloud - cloud.mean(axis=1, keepdims=True)
        out[part] = np.linalg.eigh(np.einsum("mki,mkj->mij", cloud, cloud))[1][:, :, 0]
    return out


def pca_by_view(
    points: NDArray[np.float64], view_ids: NDArray[np.integer], neighbours: int = 12
) -> NDArray[np.float64]:
    """As `pca`, with neighbours of the same view alone: other views are nearer but not better aligned.

    Views with too few points take neighbours from all.
    """
    out = np.empty_like(points)
    views, counts = np.unique(view_ids, return_counts=True)
    if (counts <= neighbours).any():
        out = pca(points, neighbours)
    for view in views[counts > neighbours]:
        mine = view_ids == view
        out[mine] = pca(points[mine], neighbours)
    return out


def _nearest(points: NDArray[np.float64], neighbours: int) -> NDArray[np.int64]:
    """Each point and its nearest neighbours, (n, neighbours + 1)."""
    if len(points) <= neighbours:
        raise InputError(f"{len(points)} points are too few for normals from {neighbours} neighbours each")
    return cKDTree(points).query(points, k=neighbours + 1, workers=-1)[1]


def toward(
    normals: NDArray[np.float64], points: NDArray[np.float64], eyes: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Normals turned to the side from which each point was seen.

    Parameters
    ----------
    normals, points, eyes : (n, 3)
    """
    facing = np.einsum("nd,nd->n", normals, eyes - points)
    return np.where(facing[:, None] < 0, -normals, normals)


def spanning_tree(
    points: NDArray[np.float64], normals: NDArray[np.float64], neighbours: int = 12
) -> NDArray[np.float64]:
    """Normals with signs made consistent along a minimum spanning tree [Hoppe et al. 1992].

    Neighbours whose tangent planes are closest to parallel pass the sign on. The topmost point of each
    connected piece of the neighbour graph starts, its normal pointing away from the piece's centroid.

    Parameters
    ----------
    points, normals : (n, 3)
    neighbours
        Of the graph.
    """
    n = len(points)
    index = _nearest(points, neighbours)[:, 1:]
    row = np.repeat(np.arange(n), neighbours)
    column = index.ravel()
    parallel = np.abs(np.einsum("nd,nd->n", normals[row], normals[column]))
    weight = 1 - np.minimum(parallel, 1) + 1e-9  # explicit zeros would be no edges
    graph = coo_array((weight, (row, column)), shape=(n, n)).tocsr()
    graph = graph.maximum(graph.T)
    tree = minimum_spanning_tree(graph)
    tree = (tree + tree.T).tocsr()
    out = normals.copy()
    count, label = connected_components(tree, directed=False)
    for piece in range(count):
        members = np.flatnonzero(label == piece)
        start = int(members[np.argmax(points[members, 2])])
        order, before = breadth_first_order(tree, start, directed=False)
        if out[start] @ (points[start] - points[members].mean(axis=0)) < 0:
            out[start] *= -1
        _pass_on(order, before, out)
    return out


@numba.njit(cache=True)
def _pass_on(order: NDArray[np.int32], before: NDArray[np.int32], normals: NDArray[np.float64]) -> None:
    """Turn each normal to its predecessor's side, in breadth-first order."""
    for i in order[1:]:
        p = before[i]
        dot = 0.0
        for d in range(3):
            dot += normals[i, d] * normals[p, d]
        if dot < 0:
            for d in range(3):
                normals[i, d] = -normals[i, d]

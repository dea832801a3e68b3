"""Normals of clouds that have none, and signs that something is wrong with those given."""

import logging

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial import cKDTree

from datasets_gen.compiled import thread_count
from medial.similarity.similarity import similarity

log = logging.getLogger(__name__)

PATCH = 16  # neighbours of a fitted plane
SAMPLE = 1200  # points of the test for inward normals
DISAGREEING = 0.15  # share of neighbours with opposite normals worth a warning; thin parts have some
INWARD = 2.0  # how much more similarity outside than inside says that normals point inward


def estimate_normals(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit normals by PCA of the nearest points, oriented along a minimum spanning tree, outward [HDD*92].

    Parameters
    ----------
    points : (n, 3)

    Returns
    -------
    (n, 3) float64
    """
    count = min(PATCH + 1, len(points))
    _, neighbours = cKDTree(points).query(points, k=count, workers=thread_count())
    patches = points[neighbours] - points[neighbours].mean(axis=1, keepdims=True)
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", patches, patches))
    return orient_normals(points, axes[:, :, 0], neighbours)


def orient_normals(
    points: NDArray[np.float64], normals: NDArray[np.float64], neighbours: NDArray[np.integer]
) -> NDArray[np.float64]:
    """Make neighbouring normals agree, component by component, then point outward.

    Outward is decided by where most medial balls fit (`inside_share`).
    """
    n, count = neighbours.shape
    rows, cols = np.repeat(np.arange(n), count - 1), neighbours[:, 1:].ravel()
    agreement = np.einsum("ij,ij->i", normals[rows], normals[cols])
    graph = csr_array((1.0 + 1e-6 - np.abs(agreement), (rows, cols)), shape=(n, n))
    tree = minimum_spanning_tree(graph.maximum(graph.T))
    pieces, labels = connected_components(tree, directed=False)
    oriented = normals.copy()
    for piece in range(pieces):
        members = np.flatnonzero(labels == piece)
        order, parents = breadth_first_order(tree, members[0], directed=False)
        for child in order[1:]:
            if oriented[child] @ oriented[parents[child]] < 0:
                oriented[child] *= -1
        away = points[members] - points[members].mean(axis=0)
        if np.einsum("ij,ij->", away, oriented[members]) < 0:
            oriented[members] *= -1
    return -oriented if inside_share(points, oriented) < 1 / (1 + INWARD) else oriented


def inside_share(points: NDArray[np.float64], normals: NDArray[np.float64]) -> float:
    """Share of the medial similarity that lies on the inner side of a sample of the cloud, in [0, 1].

    Outward normals have their medial balls below the surface, inward ones above it.
    """
    step = max(1, len(points) // SAMPLE)
    p, q = points[::step], normals[::step]
    weights = np.full(len(p), 17_500 / len(p))
    inside, outside = (similarity(p, sign * q, cutoff=1e-3, weights=weights).sum() for sign in (1, -1))
    return float(inside / (inside + outside)) if inside + outside > 0 else 1.0


def disagreement(points: NDArray[np.float64], normals: NDArray[np.float64]) -> float:
    """Share of pairs of near neighbours whose normals point into opposite half spaces."""
    count = min(7, len(points))
    _, neighbours = cKDTree(points).query(points, k=count, workers=thread_count())
    return float((np.einsum("ij,ikj->ik", normals, normals[neighbours[:, 1:]]) < 0).mean())


def check_normals(points: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Flip normals that point inward; warn where neighbours disagree.

    Returns
    -------
    (n, 3) float64
        The normals, negated if they pointed inward.
    """
    opposite = disagreement(points, normals)
    if opposite > DISAGREEING:
        log.warning(
            "%.0f %% of neighbouring normals point opposite ways; give normals=None to estimate them anew",
            100 * opposite,
        )
    share = inside_share(points, normals)
    if share < 1 / (1 + INWARD):
        log.warning(
            "normals point inward (%.0f %% of the medial balls lie outside): flipped", 100 * (1 - share)
        )
        return -normals
    return normals

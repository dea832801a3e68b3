"""Normals of clouds that have none, and signs that something is wrong with those given."""

import logging

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.compiled import thread_count
from datasets_gen.points.normals import pca, spanning_tree
from medial.similarity.similarity import similarity

log = logging.getLogger(__name__)

NEIGHBOURS = 16
"""Of a point, in its PCA and in the spanning tree."""
SAMPLE = 1200
"""Points of the test for inward normals."""
DISAGREEING = 0.15
"""Share of neighbours with opposite normals that is worth a warning; thin parts have some."""
INWARD_SHARE = 1 / 3
"""Normals point inward if less than this share of the similarity lies inside: half of that outside."""


def estimate_normals(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Outward unit normals by PCA of the nearest points and a minimum spanning tree of their signs.

    `datasets_gen.points.normals` orients each connected piece away from its centroid; then all are turned to
    where fewer medial balls fit (`inside_share`).

    Parameters
    ----------
    points : (n, 3)

    Returns
    -------
    (n, 3) float64

    Raises
    ------
    InputError
        If there are fewer than two points.
    """
    neighbours = min(NEIGHBOURS, max(1, len(points) - 1))
    oriented = spanning_tree(points, pca(points, neighbours), neighbours)
    return -oriented if inside_share(points, oriented) < INWARD_SHARE else oriented


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
    if share < INWARD_SHARE:
        log.warning(
            "normals point inward (%.0f %% of the medial balls lie outside): flipped", 100 * (1 - share)
        )
        return -normals
    return normals

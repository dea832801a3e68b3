"""Stray points: few, and far from everything else. What sets a scale must not see them."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from datasets_gen.points.neighbours import query_tree

FAR = 1.5
"""Gap to all other points from which a group is stray, in median distances of the points from their median. A
body is some five of these long; the pieces of 360 scans, up to 90 % missing, were at most 1 apart."""
FEW_SHARE, FEW = 0.01, 20
"""A stray group has at most this share of the points, or this many if that is more ..."""
LARGEST_SHARE = 0.1
"""... but never more than this share."""
NEIGHBOURS = 4


def stray_points(points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points lie in small groups far from all others.

    Groups are the connected components of the graph of nearest neighbours without edges longer than `FAR`. A
    small group is stray unless it is within `FAR` of one that is not. Medians alone set the scale, so that
    no stray point changes it by much, however far it is.

    Parameters
    ----------
    points : (n, 3)
        Finite.

    Returns
    -------
    (n,) bool
    """
    n = len(points)
    few = int(min(max(FEW_SHARE * n, FEW), LARGEST_SHARE * n))
    if few < 1:
        return np.zeros(n, dtype=bool)
    far = FAR * float(np.median(np.linalg.norm(points - np.median(points, axis=0), axis=1)))
    label = _groups(points, far)
    left = np.bincount(label)[label] <= few
    while left.any() and not left.all():
        rest = np.flatnonzero(left)
        gap, _ = query_tree(cKDTree(points[~left]), points[rest], within=far)
        near = np.isin(label, label[rest[np.isfinite(gap)]]) & left
        if not near.any():
            return left
        left &= ~near
    return np.zeros(n, dtype=bool)


def nearest_kept(points: NDArray[np.float64], stray: NDArray[np.bool_]) -> NDArray[np.int64]:
    """For each point the nearest one that is not stray, (n,), counted among those: itself, unless it is."""
    _, nearest = query_tree(cKDTree(points[~stray]), points)
    nearest[~stray] = np.arange(np.count_nonzero(~stray))
    return np.asarray(nearest, dtype=np.int64)


def _groups(points: NDArray[np.float64], far: float) -> NDArray[np.int32]:
    """Connected components of the graph of nearest neighbours that are less than `far` apart, as labels."""
    n = len(points)
    gap, near = query_tree(cKDTree(points), points, k=min(NEIGHBOURS, n - 1) + 1)
    rows = np.repeat(np.arange(n), near.shape[1])
    kept = gap.ravel() < far
    graph = coo_array((np.ones(kept.sum()), (rows[kept], near.ravel()[kept])), shape=(n, n))
    labels: NDArray[np.int32] = connected_components(graph, directed=False)[1]
    return labels


def words(stray: NDArray[np.bool_]) -> str:
    """How many points are stray, in words for a log line."""
    count = int(stray.sum())
    subject, verb = ("1 point", "lies") if count == 1 else (f"{count} points", "lie")
    return f"{subject} of {len(stray)} {verb} far from all others"

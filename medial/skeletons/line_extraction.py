"""From a thinned cloud of centres to a first graph: samples of it, joined as the body is."""

import networkx as nx
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

Float = NDArray[np.float64]
Int = NDArray[np.int64]

SURFACE_SHARE = 0.05
"""Of the way along the surface in the length of a step, so that centres at one place have an order."""
FINEST = 1.5
"""Spacings of the cloud between samples, at least."""


def sampled(centers: Float, radii: Float, points: Float, pairs: Int, step: float, spacing: float) -> Int:
    """Group points around samples of the centres that are a step from each other along the body.

    Parameters
    ----------
    centers, points : (n, 3)
    radii : (n,)
    pairs : (E, 2)
        Neighbours on the surface.
    step
        In radii of the body.
    spacing
        Of the points.

    Returns
    -------
    (n,) int64
        Group of each point, 0 to k - 1; each is connected.
    """
    i, j = pairs.T
    size = np.maximum(step * radii, FINEST * spacing)
    way = np.linalg.norm(centers[i] - centers[j], axis=1)
    way += SURFACE_SHARE * np.linalg.norm(points[i] - points[j], axis=1)
    graph = csr_array((way / np.minimum(size[i], size[j]) + 1e-12, (i, j)), shape=(len(points),) * 2)
    nearest, group, count = np.full(len(points), np.inf), np.zeros(len(points), np.int64), 0
    while nearest.max() > 1:
        start = _remotest(nearest, centers)
        found = dijkstra(graph, directed=False, indices=start, limit=min(nearest.max(), 1e300))
        closer = found < nearest
        nearest[closer], group[closer] = found[closer], count
        count += 1
    return np.unique(group, return_inverse=True)[1].astype(np.int64)


def _remotest(nearest: Float, centers: Float) -> int:
    """The point farthest from all samples; of those that none reaches, the one farthest from the middle."""
    if np.isfinite(nearest).all():
        return int(nearest.argmax())
    apart = np.flatnonzero(np.isinf(nearest))
    away = np.linalg.norm(centers[apart] - centers[apart].mean(axis=0), axis=1)
    return int(apart[away.argmax()])


def joined_groups(group: Int, centers: Float, radii: Float, pairs: Int) -> nx.Graph:
    """A graph of groups, an edge where points of two of them are neighbours.

    Each node has its ``members`` (point ids), ``place`` and ``radius``.
    """
    found = nx.Graph()
    order = np.argsort(group, kind="stable")
    for k, members in enumerate(np.split(order, np.cumsum(np.bincount(group))[:-1])):
        found.add_node(
            k, members=members, place=centers[members].mean(axis=0), radius=float(np.median(radii[members]))
        )
    ends = np.unique(np.sort(group[pairs], axis=1), axis=0)
    found.add_edges_from((int(a), int(b)) for a, b in ends if a != b)
    return found

"""Path lengths along a skeleton, and where the points of its cloud are on it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from datasets_gen.points.neighbours import join_parts
from medial.skeletons.curve_skeleton import CurveSkeleton

Float = NDArray[np.float64]
Int = NDArray[np.int64]

SAMPLES = 220
"""Places on all curves together, about."""
NEAREST_TRIED = 8
"""Places among which a point takes the first that is on an edge of its own node."""


@dataclass(frozen=True)
class SkeletonPaths:
    """Places along a skeleton, in its own unit: the mean path length between them is 1.

    Attributes
    ----------
    places : (s, 3) float64
        The nodes of the skeleton first, then places between them. In the units of the cloud.
    radii : (s,) float64
        Of the body there, in the skeleton's unit.
    lengths : (s, s) float64
        Path lengths, in the skeleton's unit; parts are joined by the shortest edges.
    tips, joints : (t,), (j,) int64
        Places with one edge, and with three or more.
    of_point : (n,) int64
        Place of every point.
    unit : float
        Length of the unit in the units of the cloud.
    """

    places: Float
    radii: Float
    lengths: Float
    tips: Int
    joints: Int
    of_point: Int
    unit: float

    @classmethod
    def of(cls, skeleton: CurveSkeleton, points: Float) -> "SkeletonPaths":
        """Places along a skeleton with at least one edge.

        Parameters
        ----------
        skeleton
        points : (n, 3)
            Its cloud.
        """
        step = max(float(skeleton.lengths.sum()) / SAMPLES, 1e-300)
        found, edge, share = skeleton.sampled(step)
        inner = (share > 0) & (share < 1)
        ids = np.where(share == 0, skeleton.edges[edge, 0], skeleton.edges[edge, 1])
        ids[inner] = len(skeleton) + np.arange(inner.sum())
        places = np.concatenate([skeleton.nodes, found[inner]])
        a, b = skeleton.edges[edge[inner]].T
        mixed = skeleton.radii[a] * (1 - share[inner]) + skeleton.radii[b] * share[inner]
        same = edge[1:] == edge[:-1]
        pairs = join_parts(np.column_stack([ids[:-1][same], ids[1:][same]]), places)
        lengths = _path_lengths(places, pairs)
        unit = float(lengths.mean())
        owner = np.concatenate([np.arange(len(skeleton)), np.where(share[inner] < 0.5, a, b)])
        return cls(
            places=places,
            radii=np.concatenate([skeleton.radii, mixed]) / unit,
            lengths=lengths / unit,
            tips=np.flatnonzero(skeleton.degrees == 1),
            joints=np.flatnonzero(skeleton.degrees > 2),
            of_point=_place_of_point(skeleton, points, places, owner),
            unit=unit,
        )

    def branch_radii(self, ends: Int, reach: float) -> Float:
        """Mean radius within a path length of some places, (len(ends),)."""
        near = self.lengths[ends] <= reach
        return np.asarray((near * self.radii).sum(axis=1) / near.sum(axis=1))


def _path_lengths(places: Float, pairs: Int) -> Float:
    i, j = pairs.T
    way = np.maximum(np.linalg.norm(places[i] - places[j], axis=1), 1e-300)
    graph = csr_array((way, (i, j)), shape=(len(places),) * 2)
    return np.asarray(dijkstra(graph, directed=False))


def _place_of_point(skeleton: CurveSkeleton, points: Float, places: Float, owner: Int) -> Int:
    """The nearest place on an edge of a point's node, (n,); the nearest of all where there is none."""
    count = min(NEAREST_TRIED, len(places))
    near = cKDTree(places).query(points, k=count)[1].reshape(len(points), -1)
    joined = np.eye(len(skeleton), dtype=bool)
    a, b = skeleton.edges.T
    joined[a, b] = joined[b, a] = True
    node = skeleton.node_of_point
    own = joined[np.maximum(node, 0)[:, None], owner[near]]
    first = near[np.arange(len(points)), own.argmax(axis=1)]
    fallback = np.where(node < 0, near[:, 0], node)
    return np.where(own.any(axis=1) & (node >= 0), first, fallback).astype(np.int64)

"""Matching by geodesic distances on the neighbour graph: what was done before diffusion, in its own words.

Points far apart on one cloud get the partners whose graph distances to each other agree best; every other
point goes where its distances to these landmarks agree best, in the manner of [TBW*09] and [HAWG08]. It
shares their weakness: gaps change the graph's distances.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from datasets_gen.points.farthest import farthest_in_metric
from datasets_gen.points.neighbours import join_parts, neighbour_pairs
from datasets_gen.values import check_count
from evaluation.experiment.toml_tables import expect
from evaluation.methods.base import Method, MethodInput, dense, require
from medial import Matching
from medial.matching.confidence import confidence_of_residual

QUANTILES = np.linspace(0.05, 0.95, 19)


@dataclass(frozen=True, kw_only=True)
class GeodesicGraph(Method):
    """Landmark distances on the graph of nearest neighbours."""

    neighbours: int = 8
    landmarks: int = 8
    """On the source; at least 3."""
    candidates: int = 60
    """Places on the target where a landmark may go."""
    kept: int = 500
    """Partners of the first three landmarks that are followed up."""

    def __post_init__(self) -> None:
        """Check ranges."""
        check_count(self.neighbours, "neighbours")
        check_count(self.kept, "kept")
        expect(self.landmarks >= 3, f"landmarks must be at least 3, got {self.landmarks!r}")
        expect(self.candidates >= self.landmarks, f"candidates must be at least {self.landmarks}")

    def match(self, source: MethodInput, target: MethodInput, seed: int) -> Matching:
        """Match extremities, then everything by its distances to them."""
        require(min(len(source), len(target)), self.candidates, "geodesic-graph matching")
        here = _LandmarkDistances(source.points, self.neighbours, self.landmarks, seed)
        there = _LandmarkDistances(target.points, self.neighbours, self.candidates, seed)
        pairs = agreeing(here, there, self.kept)
        tree = cKDTree(there.distances[pairs[:, 1]].T)
        residual, image = tree.query(here.distances[pairs[:, 0]].T)
        landmarks = np.column_stack([here.landmarks[pairs[:, 0]], there.landmarks[pairs[:, 1]]])
        confidence = confidence_of_residual(residual)
        return dense(image, confidence, landmarks=landmarks, cost=float(residual.mean()), seed=seed)


class _LandmarkDistances:
    """Landmarks of a cloud and relative distances: 1 is the mean distance between its points.

    Landmarks are in farthest-point order on the graph, from the point farthest from a random one: an
    extremity.
    """

    def __init__(self, points: NDArray[np.float64], neighbours: int, count: int, seed: int) -> None:
        graph = neighbour_graph(points, neighbours)
        random = int(np.random.default_rng(seed).integers(len(points)))
        remote = int(dijkstra(graph, indices=random).argmax())
        self.landmarks, distances = farthest_in_metric(lambda k: dijkstra(graph, indices=k), count, remote)
        self.distances = distances / distances.mean()  # (count, n)
        self.between = self.distances[:, self.landmarks]  # (count, count)
        self.profile = np.quantile(self.distances, QUANTILES, axis=1).T  # (count, quantiles)


def neighbour_graph(points: NDArray[np.float64], neighbours: int) -> csr_array:
    """Graph of nearest neighbours; what is apart is joined to the largest part by the shortest edge.

    Parameters
    ----------
    points : (n, 3)
    neighbours

    Returns
    -------
    csr_array (n, n)
        Euclidean edge lengths, positive; symmetric and connected.
    """
    i, j = join_parts(neighbour_pairs(cKDTree(points), neighbours), points, hub=True).T
    lengths = np.maximum(np.linalg.norm(points[i] - points[j], axis=1), np.finfo(float).tiny)
    both = (np.concatenate([i, j]), np.concatenate([j, i]))
    return csr_array((np.concatenate([lengths, lengths]), both), shape=(len(points), len(points)))


def agreeing(here: _LandmarkDistances, there: _LandmarkDistances, kept: int) -> NDArray[np.int64]:
    """Pairs (positions among the landmarks of either side) whose distances to each other agree best.

    All partners of the first three landmarks are tried; the best `kept` sets are extended landmark by
    landmark, each by the partner that agrees best with those before, and the set with the smallest
    disagreement wins.
    """
    unary = np.abs(here.profile[:, None] - there.profile[None]).mean(axis=2)  # (L, m)
    own, other = here.between, there.between
    first, second, third = np.ix_(*[np.arange(len(other))] * 3)
    cost = unary[0][first] + unary[1][second] + unary[2][third]
    cost = cost + np.abs(own[0, 1] - other[first, second])
    cost = cost + np.abs(own[0, 2] - other[first, third]) + np.abs(own[1, 2] - other[second, third])
    best = np.argsort(cost, axis=None)[:kept]
    sets = np.column_stack(np.unravel_index(best, cost.shape))
    total = cost.ravel()[best]
    for landmark in range(3, len(own)):
        gaps = np.abs(own[landmark, :landmark, None] - other[sets])  # (kept, landmark, m)
        step = unary[landmark] + gaps.sum(axis=1)
        partner = step.argmin(axis=1)
        total = total + step[np.arange(len(sets)), partner]
        sets = np.column_stack([sets, partner])
    return np.column_stack([np.arange(len(own)), sets[total.argmin()]])

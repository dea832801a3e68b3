"""The floor: nearest neighbours after the best rigid alignment."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.points.farthest import farthest_points
from datasets_gen.values import check_count
from evaluation.methods.base import Method, MethodInput, dense, require
from medial import Matching
from medial.matching.confidence import confidence_of_residual

FEWEST = 4
"""Points of which three axes can be found."""


@dataclass(frozen=True, kw_only=True)
class RigidNearest(Method):
    """Principal axes, the best of their four orientations, then iterative closest points."""

    iterations: int = 30
    """Of ICP."""
    samples: int = 1500
    """Points of either cloud that the alignment uses."""

    def __post_init__(self) -> None:
        """Check ranges."""
        check_count(self.iterations, "iterations", 0)
        check_count(self.samples, "samples", FEWEST)

    def match(self, source: MethodInput, target: MethodInput, seed: int) -> Matching:
        """Nearest target point of every aligned source point."""
        require(min(len(source), len(target)), FEWEST, "rigid alignment")
        placed = align(source.points, target.points, self.iterations, self.samples, seed)
        distance, nearest = cKDTree(target.points).query(placed)
        return dense(nearest, confidence_of_residual(distance), cost=float(distance.mean()), seed=seed)


def align(
    source: NDArray[np.float64], target: NDArray[np.float64], iterations: int, samples: int, seed: int
) -> NDArray[np.float64]:
    """The source moved onto the target by a similarity, (n, 3).

    The scale is the ratio of the spreads about the centroids, so that clouds in different units can be
    matched.
    """
    few = source[thinned(source, samples, seed)]
    goal = target[thinned(target, samples, seed)]
    tree = cKDTree(goal)
    best: tuple[float, NDArray[np.float64], NDArray[np.float64], float] | None = None
    centre, goal_centre = few.mean(axis=0), goal.mean(axis=0)
    scale = np.sqrt(((goal - goal_centre) ** 2).sum(1).mean() / ((few - centre) ** 2).sum(1).mean())
    for start in _orientations(few - centre, goal - goal_centre):
        turn, shift = start, goal_centre - scale * start @ centre
        for _ in range(iterations):
            moved = scale * few @ turn.T + shift
            nearest = goal[tree.query(moved)[1]]
            turn = rotation(few - centre, nearest - nearest.mean(axis=0))
            shift = nearest.mean(axis=0) - scale * turn @ centre
        cost = float(tree.query(scale * few @ turn.T + shift)[0].mean())
        if best is None or cost < best[0]:
            best = (cost, turn, shift, float(scale))
    assert best is not None
    return best[3] * source @ best[1].T + best[2]


def thinned(points: NDArray[np.float64], count: int, seed: int) -> NDArray[np.int64]:
    """Ids of farthest-point samples of points (n, d), (min(count, n),); all if there are no more."""
    if len(points) <= count:
        return np.arange(len(points))
    start = int(np.random.default_rng(seed).integers(len(points)))
    return farthest_points(points, count, start)


def _orientations(source: NDArray[np.float64], target: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """The four rotations that carry principal axes to principal axes."""
    axes = np.linalg.svd(source, full_matrices=False)[2]  # rows
    others = np.linalg.svd(target, full_matrices=False)[2]
    found = []
    for first in (1, -1):
        for second in (1, -1):
            signs = np.array([first, second, 1.0])
            turn = others.T @ np.diag(signs) @ axes
            signs[2] = np.sign(np.linalg.det(turn))
            found.append(others.T @ np.diag(signs) @ axes)
    return found


def rotation(source: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation R that minimises sum |R s - t|^2 over pairs of centred points [Kabsch 1976], (3, 3)."""
    u, _, vt = np.linalg.svd(target.T @ source)
    return u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt

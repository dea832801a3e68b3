"""Matching by curve skeletons, in the manner of [ZST*10]: the peer that the paper compares with (Fig. 10).

The skeleton graphs are matched by tips and joints, their places by path lengths to these, and the points by
their place along the skeleton and the side of it on which they lie. As there, what the skeletons say starts a
registration of the clouds: each place of the skeleton carries its points rigidly, neighbouring places alike.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.records import InputError
from evaluation.experiment.toml_tables import expect, reject_unknown
from evaluation.methods.base import Method, MethodInput, dense, require
from medial import Matching
from medial.matching.confidence import confidence_of_residual
from medial.skeletons.graph_matching import UNMATCHED, AnchorPairs, carried_places, matched_tips
from medial.skeletons.skeleton_methods import SKELETON_METHODS, skeleton_of
from medial.skeletons.skeleton_paths import SkeletonPaths

Float = NDArray[np.float64]
Int = NDArray[np.int64]

SOFTNESS = 0.15
"""Path length, in the skeleton's unit, over which places move alike."""
THIN = 0.02
"""Second principal moment of a skeleton's places over the first, up to which it is a line: turns about it are
then tried."""
CAPPED = 0.2
"""Distances between clouds that are larger, in the skeleton's unit, count as this much."""


@dataclass(frozen=True, kw_only=True)
class SkeletonMatching(Method):
    """Tips and joints of curve skeletons, then arc position and side."""

    skeleton: str = "rosa"
    """``"rosa"``, as in the paper's comparison, ``"medial"`` or ``"local-separators"``."""
    tried: int = 12
    """Sets of matched tips that the clouds decide between."""
    iterations: int = 8
    """Of the registration."""

    def __post_init__(self) -> None:
        """Check names and ranges."""
        reject_unknown([self.skeleton], SKELETON_METHODS, "method", "skeleton")
        expect(self.tried >= 1, f"tried must be at least 1, got {self.tried!r}")
        expect(self.iterations >= 1, f"iterations must be at least 1, got {self.iterations!r}")

    def match(self, source: MethodInput, target: MethodInput, seed: int) -> Matching:
        """Match the skeletons, then the points."""
        require(min(len(source), len(target)), 30, "skeleton matching")
        here, there = (_paths(each, self.skeleton) for each in (source, target))
        fits = [
            _registered(source.points, target.points, here, there, anchors, turn, self.iterations)
            for anchors in matched_tips(here, there, self.tried)
            for turn in _turns(here, source.points, target.points)
            if len(anchors.pairs)
        ]
        if not fits:
            raise InputError(
                "the skeletons have no tips or joints that could be matched; use another method for rings"
            )
        best = min(fits, key=lambda fit: fit.cost)
        sure = confidence_of_residual(best.distance) * np.clip(1 - best.change / UNMATCHED, 0, 1)
        tips = best.anchors.pairs[: best.anchors.tips]
        near = [cKDTree(each.points) for each in (source, target)]
        ends = (here.places[tips[:, 0]], there.places[tips[:, 1]])
        landmarks = np.column_stack([tree.query(at)[1] for tree, at in zip(near, ends, strict=True)])
        return dense(best.image, sure, landmarks=landmarks, cost=best.cost, seed=seed)


def _paths(cloud: MethodInput, method: str) -> SkeletonPaths:
    """The skeleton of a cloud, with path lengths; InputError if there is none."""
    found = skeleton_of(cloud.points, cloud.normals, method)
    if not len(found.edges):
        raise InputError(f"{cloud.name!r} has no curve skeleton: {found.reason}; use another method")
    return SkeletonPaths.of(found, cloud.points)


def _turns(here: SkeletonPaths, source: Float, target: Float) -> list[Float | None]:
    """Turns (3, 3) of the source to start from; None is that of the skeleton's own places.

    A skeleton that is a line does not tell the turn about it: then those are tried that take the principal
    axes of one cloud to those of the other.
    """
    if _moments(here.places)[0][1] > THIN * _moments(here.places)[0][2]:
        return [None]
    own, other = _moments(source)[1], _moments(target)[1]
    signs = [np.diag([a, b, a * b]) for a in (1.0, -1.0) for b in (1.0, -1.0)]
    hand = np.diag([1.0, 1.0, np.linalg.det(own) * np.linalg.det(other)])
    return [other @ each @ hand @ own.T for each in signs]


def _moments(points: Float) -> tuple[Float, Float]:
    """Principal moments of points, ascending, and their axes as columns."""
    offset = points - points.mean(axis=0)
    values, vectors = np.linalg.eigh(offset.T @ offset)
    return values, vectors


@dataclass(frozen=True)
class _Fit:
    """A registration: map, distances to the matches in the skeleton's unit, change of path lengths, cost."""

    anchors: AnchorPairs
    image: Int
    distance: Float
    change: Float
    cost: float


def _registered(
    source: Float,
    target: Float,
    here: SkeletonPaths,
    there: SkeletonPaths,
    anchors: AnchorPairs,
    turn: Float | None,
    iterations: int,
) -> _Fit:
    """Carry the source along the skeletons, then move every place so that its points meet their matches."""
    image, change = carried_places(here, there, anchors.pairs)
    scale = _scale(here, there, anchors.pairs)
    soft = 1 / (1 + (here.lengths / SOFTNESS) ** 2) ** 2  # (s, s)
    at, goal = here.of_point, there.places[image[here.of_point]]
    every = np.arange(len(soft))
    moves = _moves_of_points(soft, every, here.places, there.places[image])
    if turn is not None:
        moves = (np.broadcast_to(turn, (len(soft), 3, 3)), here.places, there.places[image])
    tree = cKDTree(np.hstack([target, there.places[there.of_point]]))
    for step in range(iterations + 1):
        turns, middle, end = (each[at] for each in moves)
        moved = end + scale * np.einsum("nij,nj->ni", turns, source - middle)
        distance, nearest = tree.query(np.hstack([moved, goal]))
        if step < iterations:
            moves = _moves_of_points(soft, at, source, target[nearest])
    distance = distance / there.unit
    back = cKDTree(moved).query(target)[0] / there.unit
    gaps = [np.minimum(each, CAPPED).mean() for each in (distance, back)]
    cost = float(sum(gaps)) + 0.25 * anchors.cost
    return _Fit(anchors, nearest.astype(np.int64), distance, change[at], cost)


def _scale(here: SkeletonPaths, there: SkeletonPaths, pairs: Int) -> float:
    """Units of the target per unit of the source, from the path lengths between matched places."""
    a, b = (each.lengths[np.ix_(ids, ids)] for each, ids in ((here, pairs[:, 0]), (there, pairs[:, 1])))
    far = (a > 0.3) & (b > 0.3)
    ratio = float(np.median(b[far] / a[far])) if far.any() else 1.0
    return ratio * there.unit / here.unit


def _moves_of_points(soft: Float, at: Int, points: Float, matches: Float) -> tuple[Float, Float, Float]:
    """The motion of each place from the points at it and around it, and their matches."""
    count = np.bincount(at, minlength=len(soft)).astype(np.float64)
    sums = [
        np.stack([np.bincount(at, column, len(soft)) for column in each.T], axis=1)
        for each in (points, matches, np.einsum("ni,nj->nij", points, matches).reshape(-1, 9))
    ]
    total = (soft @ count)[:, None]
    middle, end = soft @ sums[0] / total, soft @ sums[1] / total
    mixed = (soft @ sums[2] / total).reshape(-1, 3, 3) - np.einsum("si,sj->sij", middle, end)
    return _rotations(mixed), middle, end


def _rotations(mixed: Float) -> Float:
    """Rotations (s, 3, 3) that take the first side of mixed second moments to the second [Kabsch 1976]."""
    left, _, right = np.linalg.svd(mixed)
    turns = np.einsum("sji,skj->sik", right, left)
    flip = np.linalg.det(turns) < 0
    right[flip, 2] = -right[flip, 2]
    turns[flip] = np.einsum("sji,skj->sik", right[flip], left[flip])
    return np.asarray(turns)

"""Matching of skeleton graphs: tips and joints by their path lengths and radii, in the manner of [ZST*10].

Tips that agree in what they see (quantiles of path lengths, the radius of their branch) and in the path
lengths to each other belong together; not all have to. Joints are assigned by their path lengths to the
matched tips. Path lengths cannot tell left from right: several sets are kept, for the cloud to decide.

References
----------
[ZST*10] Q. Zheng et al., "Consensus skeleton for non-rigid space-time registration", Computer Graphics Forum
29(2), 2010.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from medial.skeletons.skeleton_paths import SkeletonPaths

Float = NDArray[np.float64]
Int = NDArray[np.int64]

QUANTILES = np.linspace(0.1, 0.9, 9)
BRANCH = 0.4
"""Path length from a tip, in the skeleton's unit, over which its branch's radius is taken."""
RADIUS_WEIGHT = 2.0
"""Of differences in radius against those in path lengths: radii are some tenth of these."""
UNMATCHED = 0.3
"""Cost of a tip without a partner; joints that differ by more have none."""
KEPT = 300
"""Sets that are extended by one tip after the other."""
MOST_TIPS = 14
"""The most remote tips of either side; others are left out."""


@dataclass(frozen=True)
class AnchorPairs:
    """Places of two skeletons that belong together.

    Attributes
    ----------
    pairs : (m, 2) int64
        Ids of places of either side.
    tips : int
        How many of the pairs, the first, are tips.
    cost : float
        Per tip of the source.
    """

    pairs: Int
    tips: int
    cost: float


def matched_tips(here: SkeletonPaths, there: SkeletonPaths, count: int) -> list[AnchorPairs]:
    """Sets of pairs of tips with the least cost, the best first; joints are added to each.

    Parameters
    ----------
    here, there
    count
        Largest number of sets.
    """
    own, other = (_remote(each) for each in (here, there))
    unary = _differences(here, there, own, other)
    sets: list[tuple[float, tuple[int, ...]]] = [(0.0, ())]
    for tip in range(len(own)):
        grown = []
        for cost, partners in sets:
            grown.append((cost + UNMATCHED, (*partners, -1)))
            taken = [k for k, partner in enumerate(partners) if partner >= 0]
            for partner in range(len(other)):
                if partner in partners:
                    continue
                apart = here.lengths[own[tip], own[taken]]
                goal = there.lengths[other[partner], other[[partners[k] for k in taken]]]
                change = float(np.abs(apart - goal).mean()) if taken else 0.0
                grown.append((cost + float(unary[tip, partner]) + change, (*partners, partner)))
        sets = sorted(grown)[:KEPT]
    best = [each for each in sets if sum(partner >= 0 for partner in each[1]) >= 2] or sets
    found = []
    for cost, partners in best[:count]:
        rows = [(own[k], other[partner]) for k, partner in enumerate(partners) if partner >= 0]
        pairs = np.array(rows, dtype=np.int64).reshape(-1, 2)
        found.append(with_joints(here, there, pairs, cost / max(len(own), 1)))
    return found


def _remote(paths: SkeletonPaths) -> Int:
    """The most remote tips first."""
    order = np.argsort(-paths.lengths[paths.tips].mean(axis=1), kind="stable")
    return paths.tips[order[:MOST_TIPS]]


def _differences(here: SkeletonPaths, there: SkeletonPaths, own: Int, other: Int) -> Float:
    """Difference of every two tips in what they see, (len(own), len(other))."""
    seen = [
        np.quantile(each.lengths[ids], QUANTILES, axis=1).T for each, ids in ((here, own), (there, other))
    ]
    thick = [each.branch_radii(ids, BRANCH) for each, ids in ((here, own), (there, other))]
    path = np.abs(seen[0][:, None] - seen[1]).mean(axis=2)
    return np.asarray(path + RADIUS_WEIGHT * np.abs(thick[0][:, None] - thick[1]))


def with_joints(here: SkeletonPaths, there: SkeletonPaths, pairs: Int, cost: float) -> AnchorPairs:
    """Add the joints that are assigned by their path lengths to matched tips, and by their radii."""
    tips = len(pairs)
    if tips and len(here.joints) and len(there.joints):
        a, b = (
            here.lengths[np.ix_(here.joints, pairs[:, 0])],
            there.lengths[np.ix_(there.joints, pairs[:, 1])],
        )
        apart = np.abs(a[:, None] - b).mean(axis=2)
        total = apart + np.abs(here.radii[here.joints][:, None] - there.radii[there.joints])
        rows, columns = linear_sum_assignment(total)
        good = total[rows, columns] < UNMATCHED
        joints = np.column_stack([here.joints[rows[good]], there.joints[columns[good]]])
        pairs = np.concatenate([pairs, joints])
    return AnchorPairs(pairs, tips, cost)


def carried_places(here: SkeletonPaths, there: SkeletonPaths, pairs: Int) -> tuple[Int, Float]:
    """The place of the other skeleton whose path lengths to the matched ones agree best with each place's.

    Parameters
    ----------
    here, there
    pairs : (m, 2)
        At least one.

    Returns
    -------
    image : (s,) int64
    residual : (s,) float64
        Mean difference of the path lengths, the nearer ones with more weight.
    """
    own, other = here.lengths[:, pairs[:, 0]], there.lengths[:, pairs[:, 1]]
    weights = 1 / (own + 0.1)
    weights /= weights.sum(axis=1, keepdims=True)
    change = np.einsum("sm,stm->st", weights, np.abs(own[:, None] - other[None]))
    total = change + 0.5 * np.abs(here.radii[:, None] - there.radii)
    image = total.argmin(axis=1)
    return image.astype(np.int64), change[np.arange(len(image)), image]

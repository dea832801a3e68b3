"""How good a curve skeleton is: branches too many and too few, topology, distance to known bones."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

from evaluation.metrics.skeleton_truth import BoneSegments
from medial.skeletons import CurveSkeleton

Float = NDArray[np.float64]

REACH = 0.12
"""Largest distance of a tip from the end of its bone, in sqrt(area): a skeleton ends within its limb."""
STEP = 0.01
"""Between places at which distances are measured, in sqrt(area)."""


@dataclass(frozen=True)
class SkeletonScore:
    """A skeleton against the known bones.

    Attributes
    ----------
    spurious : int
        Tips that end at no bone's free end.
    missing : int
        Free ends of bones at which no tip ends.
    parts, loops : int
        Connected parts, independent loops.
    to_bones : float
        Mean distance of the skeleton from the bones, x 100 / sqrt(area); nan without a skeleton.
    from_bones : float
        Mean distance of the bones from the skeleton, likewise.
    """

    spurious: int
    missing: int
    parts: int
    loops: int
    to_bones: float
    from_bones: float

    @property
    def right(self) -> bool:
        """Whether the topology is that of the bones: their tips and no others, one part, no loop."""
        return self.spurious == self.missing == self.loops == 0 and self.parts == 1


def skeleton_score(skeleton: CurveSkeleton, bones: BoneSegments, area: float) -> SkeletonScore:
    """Compare a skeleton with bones.

    Parameters
    ----------
    skeleton
        In the frame and units of the bones.
    bones
    area
        Of the surface.
    """
    length = float(np.sqrt(area))
    tips = skeleton.nodes[skeleton.kinds == "tip"]
    matched = matched_ends(tips, bones.tips, REACH * length)
    to_bones = from_bones = float("nan")
    if len(skeleton.edges):
        places = skeleton.sampled(STEP * length)[0]
        to_bones = 100 * float(bones.distances(places).mean()) / length
        from_bones = 100 * float(cKDTree(places).query(bones.sampled(STEP * length))[0].mean()) / length
    return SkeletonScore(
        spurious=len(tips) - matched,
        missing=len(bones.tips) - matched,
        parts=len(np.unique(skeleton.components)),
        loops=skeleton.loops,
        to_bones=to_bones,
        from_bones=from_bones,
    )


def matched_ends(found: Float, true: Float, reach: float) -> int:
    """How many of two sets of ends (f, 3) and (t, 3) can be paired one to one within a distance."""
    if not len(found) or not len(true):
        return 0
    near = np.linalg.norm(found[:, None] - true, axis=2) <= reach
    rows, columns = linear_sum_assignment(near, maximize=True)
    return int(near[rows, columns].sum())

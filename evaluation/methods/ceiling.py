"""The ceiling of an operator: landmarks from the ground truth, then Eq. 17."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.points.farthest import farthest_points
from datasets_gen.records import InputError
from datasets_gen.values import check_count
from evaluation.methods.base import MethodInput
from evaluation.methods.spectral import Spectral
from medial import Matching, extrapolate


@dataclass(frozen=True, kw_only=True)
class TruthLandmarks(Spectral):
    """What the dense part of the matcher reaches when its landmarks are right."""

    operator: str = "medial"
    """``"medial"``, ``"heat"`` or ``"robust"``."""
    landmarks: int = 5

    uses_truth = True

    def __post_init__(self) -> None:
        """Check the number of landmarks, and all else as the parent."""
        super().__post_init__()
        check_count(self.landmarks, "landmarks")

    def match(self, source: MethodInput, target: MethodInput, seed: int) -> Matching:
        """Extrapolate from true landmarks, far apart on the rest pose, that both clouds hold."""
        if source.truth is None or target.truth is None:
            raise InputError("the ceiling needs the ground truth of both clouds")
        pairs = true_landmarks(source.truth, target.truth, self.landmarks)
        here, there = source.operators[self.operator], target.operators[self.operator]
        return extrapolate(here, there, pairs, self.match_config(here.departures), seed)


def true_landmarks(source: NDArray[np.float64], target: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """Pairs of points at the same place of the rest pose, far apart from each other.

    Only the half of the source points that is closest to a target point can be chosen.

    Parameters
    ----------
    source : (n, 3), target : (m, 3)
        Positions on the rest pose.
    count

    Returns
    -------
    (count, 2) int64
    """
    gaps, partner = cKDTree(target).query(source)
    held = np.flatnonzero(gaps <= np.median(gaps))
    start = int(np.linalg.norm(source[held] - source[held].mean(axis=0), axis=1).argmax())
    chosen = held[farthest_points(source[held], min(count, len(held)), start)]
    return np.column_stack([chosen, partner[chosen]])

"""A slice of a cloud across its medial axis: a part of the surface in one plane, round a medial ball."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from reports.figures.figure_request import ScannedPose

SLICE = 1.6
"""Half the thickness of the slice, in sampling distances."""
REACH = 2.2
"""Half the width of the slice, in radii of its ball."""


@dataclass(frozen=True)
class Slice:
    """A slice of a cloud across its medial axis.

    Attributes
    ----------
    middle : int
        The point that it goes through.
    members : (m,) int
        Points of the slice, the middle among them.
    axes : (2, 3) float64
        Directions of the picture: along the normal of the middle, upwards, and across.
    """

    middle: int
    members: NDArray[np.int64]
    axes: NDArray[np.float64]

    def flat(self, each: ScannedPose, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places in the plane of the slice, relative to the medial point of the middle, (n, 2)."""
        return np.asarray((places - each.diffusion.centers[self.middle]) @ self.axes.T)


def slice_of(each: ScannedPose) -> Slice:
    """The slice with most points round one ball of about median radius.

    Raises
    ------
    InputError
        If there is none.
    """
    points, found = each.scan.points, each.diffusion
    unit = each.spacing
    middling = np.argsort(np.abs(found.radii - np.quantile(found.radii, 0.7)))[:40]
    best: Slice | None = None
    for i in middling:
        near = np.linalg.norm(found.centers - found.centers[i], axis=1) < 1.2 * found.radii[i]
        if near.sum() < 10:
            continue
        _, axes = np.linalg.eigh(np.cov(found.centers[near].T))
        along = axes[:, 2]
        up = each.scan.normals[i] - (each.scan.normals[i] @ along) * along
        if np.linalg.norm(up) < 0.9:  # the normal must lie in the slice
            continue
        up /= np.linalg.norm(up)
        offset = points - found.centers[i]
        inside = (np.abs(offset @ along) < SLICE * unit) & (
            np.linalg.norm(offset, axis=1) < REACH * found.radii[i]
        )
        if best is None or inside.sum() > len(best.members):
            best = Slice(int(i), np.flatnonzero(inside), np.array([np.cross(up, along), up]))
    if best is None:
        raise InputError("the scan has no part round enough for a slice; give more points or another pose")
    return best

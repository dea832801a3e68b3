"""What fits of both directions are compared by: where they put the samples of the source, and their worth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from medial.matching.common_units import CloudInUnits, Int
from medial.matching.landmarks.medial_paths import path_distortion
from medial.matching.registration.closest_points import mean_distance
from medial.matching.registration.direction import DirectedFit

ALIKE = 0.075
"""Mean distance between two maps, in sqrt(area), below which they differ in a limb, not as a whole."""
SAME_REGION = 0.1
"""Medial centres closer than this, in sqrt(area), are of one region."""
UNMOVED = 0.8
"""Share of the points to be moved from which a map leaves the body where it is. Of the outer half of a
quadruped the left-right symmetry leaves .44 (head and tail), with two legs not found .68, a turn of front to
back all."""
UNMOVED_COST = 0.5
"""Cost of that share in the score: part of a body turned from front to back strains less than it should."""


@dataclass(frozen=True)
class Placement:
    """Where a fit of either direction puts the samples of the pair's source.

    Attributes
    ----------
    places : (s, 3) float64
        On the pair's target.
    score : float
        Of the fit, less the cost of what it leaves in place and of what it changes along the body.
    """

    places: NDArray[np.float64]
    score: float

    def gap(self, other: "Placement") -> float:
        """Mean distance between two placements, in sqrt(area)."""
        return mean_distance(self.places, other.places)

    def like(self, other: "Placement") -> bool:
        """Whether two placements differ by no more than a limb."""
        return self.gap(other) < ALIKE


def place(fit: DirectedFit) -> Placement:
    """Where a fit puts the samples of the pair's source; with its inverse if the target is deformed."""
    places = fit.direction.source.cloud.points[fit.inverse] if fit.backward else fit.moved
    weights = fit.weights
    cost = weights.paths if fit.direction.pair.to_move is None else weights.mirrored_paths
    score = fit.score - UNMOVED_COST * unmoved(fit) - cost * path_change(fit)
    return Placement(places, score)


def path_change(fit: DirectedFit) -> float:
    """How much a fit changes paths along the body, in sqrt(area): mean of there and back; 0 without paths.

    Both count alike, so that fits of the two directions compare. Where two limbs come to lie on one, the
    paths of the one say little and those of the two say much.
    """
    here, there = fit.direction.source, fit.direction.target
    if here.paths is None or there.paths is None:
        return 0.0
    out = path_distortion(here.paths, there.paths, here.descriptors.samples, fit.partner)
    home = path_distortion(there.paths, here.paths, there.descriptors.samples, fit.inverse)
    return (out + home) / 2


def unmoved(fit: DirectedFit) -> float:
    """Share of the points to be moved that a fit leaves in place (`unmoved_share`); 0 if none are."""
    to_move, source = fit.direction.pair.to_move, fit.direction.source
    if to_move is None:
        return 0.0
    samples = source.descriptors.samples
    some = to_move[samples]
    return unmoved_share(source.cloud, samples[some], fit.partner[some])


def unmoved_share(cloud: CloudInUnits, points: Int, matches: Int) -> float:
    """Share of points that a map of a cloud to itself leaves in the medial region that they are in.

    Parameters
    ----------
    cloud
        Lengths are in sqrt(area).
    points, matches : (s,) int64
        Point ids, and where the map takes them.

    Returns
    -------
    float
        In [0, 1]; 0 without points.
    """
    gap = np.linalg.norm(cloud.centers[matches] - cloud.centers[points], axis=1)
    return float((gap < SAME_REGION).mean()) if len(gap) else 0.0

"""Errors of a correspondence: geodesic, symmetry-aware and medial; curves and overlap.

All lengths are divided by the square root of the reference's area (its unit is "sqrt(area)"); results
tables hold them times 100. Nothing here runs a method: maps are stored and scored later.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.records import InputError
from datasets_gen.shape import Shape
from evaluation.metrics.geodesic import SurfaceDistance

CURVE = np.linspace(0, 0.25, 51)
"""Errors at which the curve of [KLF11] is sampled, in sqrt(area)."""
SURE = 0.9
"""Confidence above which a point is sure."""
RIGHT = 0.1
"""Error below which a point is right, in sqrt(area): on the right part of a limb."""
GROSS_ERROR = 0.15
"""Mean error above which a map is grossly wrong, in sqrt(area): turned, flipped or with limbs swapped."""


@dataclass(frozen=True)
class SurfacePoints:
    """Points of a mesh and of all its poses.

    Attributes
    ----------
    face_ids : (n,) integer
    barycentrics : (n, 3) float64
    """

    face_ids: NDArray[np.integer]
    barycentrics: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.face_ids)

    def __getitem__(self, index: NDArray[np.integer] | NDArray[np.bool_]) -> "SurfacePoints":
        """The points of an index or mask."""
        return SurfacePoints(self.face_ids[index], self.barycentrics[index])

    def on(self, shape: Shape) -> NDArray[np.float64]:
        """Positions on one pose, (n, 3)."""
        return shape.at(self.face_ids, self.barycentrics)


def correspondence_error(
    distance: SurfaceDistance,
    source: SurfacePoints,
    target: SurfacePoints,
    source_to_target: NDArray[np.integer],
    area: float,
) -> NDArray[np.float64]:
    """Geodesic distance, on the reference, between where each point is mapped and where it belongs.

    Parameters
    ----------
    distance
        Distances on the reference mesh.
    source, target
        Where the two clouds' points lie on the surface.
    source_to_target : (n_source,)
        Target point of every source point; -1 for none.
    area
        Area of the reference.

    Returns
    -------
    (n_source,) float64
        In sqrt(area); nan for points without a match.

    Raises
    ------
    InputError
        If the map does not fit the clouds.
    """
    if len(source_to_target) != len(source):
        raise InputError(f"a map of {len(source_to_target)} points does not fit a source of {len(source)}")
    if len(source_to_target) and not -1 <= source_to_target.min() <= source_to_target.max() < len(target):
        raise InputError(
            f"the map holds target ids from {source_to_target.min()} to {source_to_target.max()}; "
            f"they must lie in [0, {len(target)}), or be -1 for no match"
        )
    errors = np.full(len(source), np.nan)
    matched = np.flatnonzero(source_to_target >= 0)
    goal, start = target[source_to_target[matched]], source[matched]
    errors[matched] = distance(start.face_ids, start.barycentrics, goal.face_ids, goal.barycentrics)
    return errors / np.sqrt(area)


def least_errors(
    distance: SurfaceDistance, source: SurfacePoints, target: SurfacePoints, area: float
) -> NDArray[np.float64]:
    """The least error that any map can have at each point: ``min_j d(x_i, y_j)`` over the target's points.

    Parameters
    ----------
    distance, source, target, area
        As for `correspondence_error`, whose errors are no lower, with any map, by more than rounding.

    Returns
    -------
    (n_source,) float64
        In sqrt(area).
    """
    found = distance.to_nearest(source.face_ids, source.barycentrics, target.face_ids, target.barycentrics)
    return found / np.sqrt(area)


def with_unmatched(
    errors: NDArray[np.float64], random: NDArray[np.float64], least: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Errors in which a point without a match counts like a random match.

    Leaving a point out is no better than guessing: it costs what a place drawn from the whole body would cost
    on average, and never less than the best match there is.

    Parameters
    ----------
    errors : (n,)
        Of `correspondence_error`; nan for points without a match.
    random : (n,)
        Mean distance of the body from each right place, in the same unit.
    least : (n,)
        Of `least_errors`.
    """
    return np.where(np.isnan(errors), np.maximum(random, least), errors)


def sure_and_right(errors: NDArray[np.float64], confidence: NDArray[np.float64]) -> float | None:
    """Share of points with a confidence above `SURE` whose error is below `RIGHT`; None if there are none.

    Parameters
    ----------
    errors : (n,)
        In sqrt(area); nan for points without a match, which do not count.
    confidence : (n,)
    """
    sure = errors[(confidence > SURE) & ~np.isnan(errors)]
    return float((sure < RIGHT).mean()) if len(sure) else None


def pck_curve(errors: NDArray[np.float64], at: NDArray[np.float64] = CURVE) -> NDArray[np.float64]:
    """Share of points with an error of at most each value ([KLF11]); points without a match never count.

    Parameters
    ----------
    errors : (n,)
        In sqrt(area); nan for no match.
    at : (m,)

    Returns
    -------
    (m,) float64
    """
    ordered = np.sort(np.where(np.isnan(errors), np.inf, errors))
    return np.searchsorted(ordered, at, side="right") / max(len(errors), 1)


def area_under_curve(curve: NDArray[np.float64], at: NDArray[np.float64] = CURVE) -> float:
    """Area under a `pck_curve`, relative to that of a perfect map."""
    return float(np.trapezoid(curve, at) / (at[-1] - at[0]))


def symmetric_mean(direct: float, mirrored: float) -> tuple[float, bool]:
    """The better of a map's mean errors to the truth and to its mirror image, and whether it is the latter.

    One choice per map: choosing per point would reward maps that mix both.
    """
    return (mirrored, True) if mirrored < direct else (direct, False)


def overlap(source: NDArray[np.float64], target: NDArray[np.float64], radius: float) -> NDArray[np.bool_]:
    """Source points that have a counterpart: a target point within `radius` on the reference.

    Parameters
    ----------
    source : (n, 3), target : (m, 3)
        Positions on the reference.
    radius
        Usually a few spacings of the target.

    Returns
    -------
    (n,) bool
    """
    return cKDTree(target).query(source)[0] <= radius


def intersection_over_union(predicted: NDArray[np.bool_], truth: NDArray[np.bool_]) -> float:
    """Size of the intersection over that of the union; 1 if both are empty."""
    union = int((predicted | truth).sum())
    return float((predicted & truth).sum() / union) if union else 1.0

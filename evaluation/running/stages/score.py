"""Scores: Eq. 18 of a cloud, or the errors of a map."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen import Collection, Shape
from datasets_gen.meshes.geometry import face_normals
from evaluation.metrics.correspondence import (
    GROSS_ERROR,
    SurfacePoints,
    area_under_curve,
    correspondence_error,
    intersection_over_union,
    least_errors,
    overlap,
    pck_curve,
    sure_and_right,
    symmetric_mean,
    with_unmatched,
)
from evaluation.metrics.diffusion_error import diffusion_error
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.metrics.limbs import Limbs, find_limbs, limb_shares
from evaluation.metrics.medial_errors import MedialRuler
from evaluation.metrics.mirror_images import mirror_points
from evaluation.running.stages.interface import Inputs, Output
from medial.matching.result import CONFIDENT
from scanner_sim import Scan

OVERLAP_SPACINGS = 2.0
"""A source point has a counterpart if a target point lies within this many spacings, sqrt(area / points)."""


def compute(spec: Mapping[str, Any], inputs: Inputs) -> Output:
    """Score one cloud (``kind`` stability) or one map (``kind`` matching)."""
    return score_operator(spec, inputs) if spec["kind"] == "stability" else score_map(spec, inputs)


def score_operator(spec: Mapping[str, Any], inputs: Inputs) -> Output:
    """Eq. 18 of the operator of a cloud.

    ``spec``: ``pairs``, ``times``, ``seed``, ``scale`` (of the cloud). Inputs: ``shape``, ``scan``,
    ``operator``, ``reference_operator``.
    """
    scan, reference = inputs.load("scan"), inputs.load("shape").reference
    found = diffusion_error(
        inputs.load("reference_operator"),
        inputs.load("operator"),
        reference.at(scan.face_ids, scan.barycentrics),
        face_normals(reference.vertices, reference.faces)[scan.face_ids],
        reference.area,
        pairs=spec["pairs"],
        times=spec["times"],
        seed=spec["seed"],
        scale=spec["scale"],
    )
    row = {"eq18": found.eq18, "eq18_trace": found.eq18_trace, "eq18_relative": found.eq18_relative}
    row |= {"n_points": len(scan), "source_missing": inputs.note("scan")["missing"]}
    return Output(None, {"row": row, "times": found.times.tolist(), "per_time": found.per_time.tolist()})


def score_map(spec: Mapping[str, Any], inputs: Inputs) -> Output:
    """Errors of a map.

    ``spec``: ``evaluated`` (points at which to measure), ``seed``. Inputs: ``shape``, ``source_scan``,
    ``target_scan``, ``map``, ``reference_scan``, ``reference_medial``.

    A point without a match counts like a random one (`with_unmatched`) in every mean, and as wrong in every
    share; ``matched`` is the share of points that have a match. ``geodesic_best`` is the lowest mean error
    among the map and the alternatives that its method gave with it.
    """
    collection: Collection = inputs.load("shape")
    reference, found = collection.reference, inputs.load("map")
    source, target = surface(inputs.load("source_scan")), surface(inputs.load("target_scan"))
    picked = _evaluated(len(source), spec)
    start, image = source[picked], found.source_to_target[picked]
    distance, limbs = inputs.derive("shape", reference_ruler)
    ends = distance, start, target
    given = correspondence_error(*ends, image, reference.area)
    least = least_errors(*ends, reference.area)
    random = limbs.remoteness_of(reference, start) / np.sqrt(reference.area)
    errors = with_unmatched(given, random, least)
    others = [
        _mean(with_unmatched(correspondence_error(*ends, other[picked], reference.area), random, least))
        for other in (each.source_to_target for each in found.alternatives)
    ]
    confident = (found.confidence[picked] >= CONFIDENT) & (image >= 0)
    curve = pck_curve(given)
    there = overlap(start.on(reference), target.on(reference), _radius(reference, len(target)))
    row = {
        "geodesic_mean": 100 * _mean(errors),
        "geodesic_median": 100 * float(np.median(errors)),
        "geodesic_overlap": 100 * _mean(errors[there]),
        "geodesic_best": 100 * min([_mean(errors), *others]),
        "oracle_mean": 100 * _mean(least),
        "excess_mean": 100 * _mean(errors - least),
        "gross": _mean(errors) > GROSS_ERROR,
        "matched": float((image >= 0).mean()),
        "pck_auc": area_under_curve(curve),
        **{f"pck_{name}": float(pck_curve(given, np.array([at]))[0]) for name, at in _LEVELS.items()},
        **_medial_errors(inputs, reference, start, target, image),
        "coverage": float(confident.mean()),
        "error_confident": 100 * _mean(errors[confident]),
        "sure_right": sure_and_right(given, found.confidence[picked]),
        "overlap_iou": intersection_over_union(confident, there),
        "overlap": float(there.mean()),
        "distinct": _distinct(found.source_to_target) / min(len(source), len(target)),
        "probability": found.probability,
        "alternatives": len(found.alternatives),
        "mirror_check": found.mirror_check,
        "n_points": len(source),
        "source_missing": inputs.note("source_scan")["missing"],
        "target_missing": inputs.note("target_scan")["missing"],
    }
    row |= _limbs(limbs, reference, start, target, image)
    row |= _symmetry(collection, distance, start, target, image, errors)
    return Output(None, {"row": {k: _finite(v) for k, v in row.items()}, "curve": curve.tolist()})


_LEVELS = {"01": 0.01, "02": 0.02, "05": 0.05, "10": 0.10, "20": 0.20}


def surface(scan: Scan) -> SurfacePoints:
    """Where a scan's points lie on the mesh."""
    return SurfacePoints(scan.face_ids, scan.barycentrics)


def reference_ruler(collection: Collection) -> tuple[SurfaceDistance, Limbs]:
    """Distances on the rest pose, and its limbs."""
    distance = SurfaceDistance(collection.reference)
    return distance, find_limbs(collection.reference, distance, collection.mirror)


def _evaluated(n: int, spec: Mapping[str, Any]) -> NDArray[np.int64]:
    """Points at which a map is measured: the same for every method."""
    count = min(n, spec["evaluated"])
    return np.sort(np.random.default_rng(spec["seed"]).choice(n, size=count, replace=False))


def _radius(reference: Shape, points: int) -> float:
    return float(OVERLAP_SPACINGS * np.sqrt(reference.area / points))


def _medial_errors(
    inputs: Inputs, reference: Shape, start: SurfacePoints, target: SurfacePoints, image: NDArray[np.int64]
) -> dict[str, float]:
    """Mean distances of the rest pose's medial centres at the right and the found place."""
    matched, right = image >= 0, start.on(reference)
    ruler = inputs.derive("reference_medial", MedialRuler.of)
    errors = np.empty((2, len(start)))
    found = target[image[matched]].on(reference)
    errors[:, matched] = ruler.distances(right[matched], found)
    errors[:, ~matched] = ruler.mean_distances(right[~matched])
    straight, along = 100 / np.sqrt(reference.area) * errors.mean(axis=1)
    return {"medial_mean": float(straight), "medial_path_mean": float(along)}


def _limbs(
    limbs: Limbs, reference: Shape, start: SurfacePoints, target: SurfacePoints, image: NDArray[np.int64]
) -> dict[str, Any]:
    """Shares of the limbs that are mapped to the right limb and to its mirror image."""
    shown = limbs.of_points(reference, target)
    there = np.where(image >= 0, shown[image], -1)
    right, mirrored = limb_shares(limbs.of_points(reference, start), there, shown, limbs.mirror)
    return {"right_limb": right, "mirror_limb": mirrored}


def _symmetry(
    collection: Collection,
    distance: SurfaceDistance,
    start: SurfacePoints,
    target: SurfacePoints,
    image: NDArray[np.int64],
    errors: NDArray[np.float64],
) -> dict[str, Any]:
    """The symmetry-aware error and whether the map is flipped; unknown without a mirror map or any match.

    Points without a match have the same error either way.
    """
    direct = 100 * _mean(errors)
    if collection.mirror is None or not (image >= 0).any():
        return {"geodesic_symmetric_mean": direct, "flipped": None}
    other = mirror_points(collection.reference, collection.mirror, start)
    found = correspondence_error(distance, other, target, image, collection.reference.area)
    mean, flipped = symmetric_mean(direct, 100 * _mean(np.where(np.isnan(found), errors, found)))
    return {"geodesic_symmetric_mean": mean, "flipped": flipped}


def _distinct(image: NDArray[np.int64]) -> int:
    """Number of target points that have a partner."""
    return len(np.unique(image[image >= 0]))


def _mean(values: NDArray[np.float64]) -> float:
    """Mean of the values that are there; nan if none is."""
    there = values[~np.isnan(values)]
    return float(there.mean()) if len(there) else float("nan")


def _finite(value: Any) -> Any:
    """None for a number that is not finite, which JSON cannot hold."""
    return None if isinstance(value, float) and not np.isfinite(value) else value

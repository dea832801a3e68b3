"""The error of a map between meshes that was made anywhere, against a ground truth in a file."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from datasets_gen.correspondences.point_map import PointMap
from datasets_gen.mesh_placement import MeshPlacement
from datasets_gen.records import InputError
from datasets_gen.shape import Shape
from evaluation.metrics.correspondence import (
    SurfacePoints,
    area_under_curve,
    least_errors,
    pck_curve,
    symmetric_mean,
    with_unmatched,
)
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.metrics.limbs import Limbs, find_limbs, limb_shares
from evaluation.metrics.scanned_subject import check_subject
from scanner_sim import Scan

LEVELS = np.array([0.01, 0.02, 0.05, 0.1, 0.2])
"""Errors at which the share of points below is told, in sqrt(area)."""


@dataclass(frozen=True, repr=False)
class MapScore:
    """Errors of a map at the source points whose right place is known.

    Attributes
    ----------
    source_ids : (n,) int64
        The source points.
    errors : (n,) float64
        Geodesic distance on the target between found and right place, in sqrt(area); nan without a match, or
        with one on a piece that is not connected with the right place.
    counted : (n,) float64
        The same with points without a match counted like random ones
        (`evaluation.metrics.correspondence.with_unmatched`): what means are taken of.
    elsewhere : int
        Points that are mapped to a piece of the target that is not connected with the right place.
    symmetric : float or None
        The lower of the mean errors to the truth and to its mirror image.
    flipped : bool or None
        Whether that is the mirror image's.
    least : float or None
        The least mean error that a map between two scans can have, in sqrt(area).
    right_limb, mirror_limb : float or None
        Shares of the limbs that are mapped to the right limb and to its mirror image
        (`evaluation.metrics.limbs.limb_shares`); None if the body has none, or its mirror map is unknown.
    """

    source_ids: NDArray[np.int64]
    errors: NDArray[np.float64]
    counted: NDArray[np.float64]
    elsewhere: int = 0
    symmetric: float | None = None
    flipped: bool | None = None
    least: float | None = None
    right_limb: float | None = None
    mirror_limb: float | None = None

    def __repr__(self) -> str:
        """Name the number of points and the mean errors, x 100 / sqrt(area)."""
        least = "" if self.least is None else f", least {100 * self.least:.2f}"
        mean = f"{100 * self.counted.mean():.2f}" if len(self.counted) else "unknown"
        return f"MapScore({len(self.errors)} points, mean {mean}{least})"

    @property
    def matched(self) -> float:
        """Share of the points that have a match."""
        return float((~np.isnan(self.errors)).mean())

    def summary(self) -> dict[str, float | int | bool | None]:
        """Numbers by name; errors are x 100 / sqrt(area), shares in percent."""
        curve = pck_curve(self.errors)
        below = pck_curve(self.errors, LEVELS)
        return {
            "points": len(self.errors),
            "matched %": 100 * self.matched,
            "mean": 100 * float(self.counted.mean()),
            **({} if self.least is None else {"least mean": 100 * self.least}),
            "median": 100 * float(np.median(self.counted)),
            "max": 100 * float(self.counted.max()),
            **{f"PCK@{100 * at:g} %": 100 * float(b) for at, b in zip(LEVELS, below, strict=True)},
            "AUC": 100 * area_under_curve(curve),
            **({} if self.symmetric is None else {"symmetric mean": 100 * self.symmetric}),
            **({} if self.flipped is None else {"flipped": self.flipped}),
            **({} if self.right_limb is None else {"limbs right %": 100 * self.right_limb}),
            **({} if self.mirror_limb is None else {"limbs mirrored %": 100 * self.mirror_limb}),
        }


def score_map(
    found: PointMap,
    truth: PointMap,
    target: Shape,
    mirrored: PointMap | None = None,
    area: float | None = None,
    reached: SurfacePoints | None = None,
    mirror: NDArray[np.int64] | None = None,
) -> MapScore:
    """Score a map of vertices against the truth.

    Parameters
    ----------
    found
        For each source vertex a vertex of the target, or a triangle of it with weights.
    truth
        The same, right. Source vertices without a right place (-1) are left out.
    target
        An oriented manifold; boundaries and several pieces are allowed.
    mirrored
        The truth's mirror image, for the symmetric error: one choice for the whole map.
    area
        Errors are divided by its square root. Default: the area of the target.
    reached
        The places that a map can lead to, for the least error. Default: all, and no least error.
    mirror : (v,) or None
        Vertex of the target that mirrors each vertex, for the limbs.

    Raises
    ------
    InputError
        If the maps do not fit each other or the target, or the truth holds no point.
    """
    if len(found) != len(truth):
        raise InputError(
            f"the map has {len(found)} points, the ground truth {len(truth)}; give maps of the same vertices"
        )
    picked = np.flatnonzero(truth.matched)
    if not len(picked):
        raise InputError("the ground truth holds no point; give one that does")
    for each, name in ((found, "the map"), (truth, "the ground truth")):
        each.check_target(len(target.vertices), len(target.faces), name)
    distance = SurfaceDistance(target)
    area = target.area if area is None else area
    limbs, size = find_limbs(target, distance, mirror), float(np.sqrt(area))
    right = places(truth, target, picked)
    errors, counted, elsewhere = _errors(found, right, picked, target, distance, limbs.remoteness, size)
    least = None if reached is None else float(least_errors(distance, right, reached, area).mean())
    right_limb, mirror_limb = _limbs(limbs, found, right, picked, target, reached)
    score = MapScore(
        picked, errors, counted, elsewhere, least=least, right_limb=right_limb, mirror_limb=mirror_limb
    )
    if mirrored is None:
        return score
    if len(mirrored) != len(truth) or not mirrored.matched[picked].all():
        raise InputError("the mirrored ground truth lacks points that the ground truth has")
    mirrored.check_target(len(target.vertices), len(target.faces), "the ground truth")
    image = places(mirrored, target, picked)
    other = _errors(found, image, picked, target, distance, limbs.remoteness, size)[1]
    mean, flipped = symmetric_mean(float(counted.mean()), float(other.mean()))
    return replace(score, symmetric=mean, flipped=flipped)


def score_scans(
    found: PointMap,
    source: Scan,
    target: Scan,
    mesh: Shape,
    area: float | None = None,
    mirror: NDArray[np.int64] | None = None,
) -> MapScore:
    """Score a map between two scans of one subject by where their points lie on its mesh.

    Parameters
    ----------
    found
        For each point of the source scan a point of the target scan.
    source, target
    mesh
        Any pose of the subject: distances are measured on it.
    area, mirror
        As for `score_map`.

    Raises
    ------
    InputError
        If the map is not between these scans, or the scans are of other meshes.
    """
    if len(found) != len(source) or found.weights is not None:
        raise InputError(
            f"the map has {len(found)} points, the source scan {len(source)}; give its two scans"
        )
    found.check_target(len(target), 0, "the map")
    for scan in (source, target):
        if scan.face_ids.min() < 0 or scan.face_ids.max() >= len(mesh.faces):
            raise InputError(
                f"the scan of {scan.shape_name!r} names faces {scan.face_ids.min()} to {scan.face_ids.max()} "
                f"of a mesh of {len(mesh.faces)}; give a pose of the subject that was scanned"
            )
        check_subject(scan, mesh)
    subjects = [scan.shape_name.rpartition("/")[0] for scan in (source, target)]
    if all(subjects) and subjects[0] != subjects[1]:
        raise InputError(
            f"the scans are of {subjects[0]!r} and {subjects[1]!r}; give two scans of one subject"
        )
    ids = np.where(found.matched, target.face_ids[found.ids], -1).astype(np.int64)
    weights = np.where(found.matched[:, None], target.barycentrics[found.ids], 0.0)
    truth = PointMap(source.face_ids.astype(np.int64), source.barycentrics)
    reached = SurfacePoints(target.face_ids, target.barycentrics)
    return score_map(PointMap(ids, weights, found.confidence), truth, mesh, None, area, reached, mirror)


def truth_of_pair(source: PointMap, target: PointMap, vertices: int) -> PointMap:
    """The ground truth between two shapes from a template's maps to each of them.

    Parameters
    ----------
    source, target
        For each template point, its vertex on the source and on the target.
    vertices
        Of the source.

    Returns
    -------
    PointMap
        For each source vertex the target vertex of the same template point; -1 where no template point lies.
        Of several template points on one vertex, the first counts.

    Raises
    ------
    InputError
        If the two do not belong together, or name a vertex that the source lacks.
    """
    if len(source) != len(target):
        raise InputError(f"{len(source)} template points on the source, {len(target)} on the target")
    source.check_target(vertices, 0, "the ground truth of the source")
    both = source.matched & target.matched
    vertex, first = np.unique(source.ids[both], return_index=True)
    ids = np.full(vertices, -1, dtype=np.int64)
    ids[vertex] = target.ids[both][first]
    return PointMap(ids)


def places(points: PointMap, target: Shape, picked: NDArray[np.integer]) -> SurfacePoints:
    """Where some rows of a map, all of them matched, lie on the target."""
    if points.weights is None:
        found = MeshPlacement.of_vertices(points.ids[picked], target)
        return SurfacePoints(found.face_ids, found.barycentrics)
    weights = np.clip(points.weights[picked], 0, None)
    return SurfacePoints(points.ids[picked], weights / weights.sum(axis=1, keepdims=True))


def _errors(
    found: PointMap,
    right: SurfacePoints,
    picked: NDArray[np.int64],
    target: Shape,
    distance: SurfaceDistance,
    field: NDArray[np.float64],
    size: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Errors, errors as they count, and how many points are on another piece."""
    errors, matched = np.full(len(picked), np.nan), found.matched[picked]
    goal, start = places(found, target, picked[matched]), right[matched]
    errors[matched] = distance(start.face_ids, start.barycentrics, goal.face_ids, goal.barycentrics) / size
    apart = np.isinf(errors)
    errors[apart] = np.nan
    random = np.einsum("nc,nc->n", right.barycentrics, field[target.faces[right.face_ids]]) / size
    return errors, with_unmatched(errors, random, np.zeros(len(errors))), int(apart.sum())


def _limbs(
    limbs: Limbs,
    found: PointMap,
    right: SurfacePoints,
    picked: NDArray[np.int64],
    target: Shape,
    reached: SurfacePoints | None,
) -> tuple[float | None, float | None]:
    """Shares of the limbs on the right limb and on its mirror image."""
    matched, there = found.matched[picked], np.full(len(picked), -1, dtype=np.int64)
    there[matched] = limbs.of_points(target, places(found, target, picked[matched]))
    shown = limbs.of_vertex if reached is None else limbs.of_points(target, reached)
    return limb_shares(limbs.of_points(target, right), there, shown, limbs.mirror)

"""One scan: views, stripes, peaks, triangulation."""

import logging
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.checks import looks_inward
from datasets_gen.meshes.geometry import solid_faces
from datasets_gen.points import normals
from datasets_gen.records import InputError
from datasets_gen.shape import Shape
from datasets_gen.values import check_seed
from scanner_sim import view_alignment
from scanner_sim.leading_reason import nothing_acquired, shows
from scanner_sim.motion import passes, profiler, stations
from scanner_sim.optics.hits import Hits
from scanner_sim.optics.measurement import ViewMeasurement, measure
from scanner_sim.optics.verdict import Verdict
from scanner_sim.scan import Scan
from scanner_sim.scanner_config import ScannerConfig
from scanner_sim.tracing import brute_force, variant
from scanner_sim.tracing.materials import Attributes
from scanner_sim.tracing.tracer import Tracer

_log = logging.getLogger(__name__)


def scan(
    shape: Shape, config: ScannerConfig | None = None, seed: int = 0, attributes: Attributes | None = None
) -> Scan:
    """Scan a shape with the laser-triangulation scanner of [BLN*11].

    Parameters
    ----------
    shape
        Triangle mesh in any units, in any number of pieces, open or closed: the rig is scaled to its
        surface. A (nearly) closed mesh whose faces look inward is scanned as if they looked outward.
    config
        The rig; ``ScannerConfig()`` if not given. To sweep thresholds, scan once at a low
        `peak_threshold` and use `Scan.accept`.
    seed
        Of all noise. Same shape, config and seed: same scan, whatever the number of threads.
    attributes
        Values per vertex (``vertex_...``) or face (``face_...``) that the material uses.

    Returns
    -------
    Scan
        In the mesh's own frame and units.

    Raises
    ------
    InputError
        If the shape has no extent, or not a single point was acquired.
    """
    if not isinstance(shape, Shape):
        raise InputError(
            f"scan takes a Shape, got {type(shape).__name__}; medialbench.scan takes files, meshes and arrays"
        )
    config, seed = ScannerConfig() if config is None else config, check_seed(seed)
    outward = facing_outward(shape)
    rig = Rig(outward, config, attributes)
    with variant.active(rig.tracer.variant):  # once for all views: switching takes as long as a view
        views = [rig.view(number, seed) for number in range(len(rig.poses))]
    found = _assemble(rig, seed, views)
    if outward is not shape:
        found = replace(found, barycentrics=np.ascontiguousarray(found.barycentrics[:, [0, 2, 1]]))
    return replace(found, shape_name=shape.name)


class Rig:
    """Camera, laser and one shape, ready to look from every viewpoint.

    Parameters
    ----------
    shape
        With faces that look outward.
    config
    attributes
        For the material.

    Attributes
    ----------
    poses : (looks, 4, 4) float64
        Camera-to-rig matrices, mm: those of the first camera from all V stations, then those of the second,
        if there is one; of a profiler in the first frame of each pass.
    stations : int
        V.
    tracers : list of Tracer
        Of each camera; its `config` has the baseline as that camera sees it.
    passes : list of Pass
        Of a profiler, one per station.
    """

    def __init__(self, shape: Shape, config: ScannerConfig, attributes: Attributes | None = None) -> None:
        _check(shape)
        self.shape = shape
        self.config = config
        self.tracer = Tracer(shape, config, attributes=attributes)
        self.tracers = stations.tracers(self.tracer)
        self.poses = stations.poses(config, self.tracer.frame)
        self.stations = len(self.poses) // config.cameras
        self.passes: list[passes.Pass] = []
        if config.motion == "profiler":
            self.passes = passes.plan_all(self.tracer.vertices, self.poses[: self.stations], config)
            self.poses[:, :3, 3] += np.tile([each.start for each in self.passes], (config.cameras, 1))
        stations.check_outside(self._places(), self.tracer.vertices[shape.faces], shape.name)

    def config_of(self, number: int) -> ScannerConfig:
        """What the camera of a look works with: the second has the laser on its other side."""
        return self.tracers[number // self.stations].config

    def _places(self) -> list[tuple[str, NDArray[np.float64]]]:
        """Names and places in the rig, mm, (k, 3), of every camera and laser over all frames."""
        found = []
        for number, pose in enumerate(self.poses):
            laser = pose[:3, 3] + self.config_of(number).baseline * pose[:3, 0]
            moved = self.passes[number % self.stations].track() if self.passes else np.zeros((1, 3))
            found += [(f"camera of view {number}", pose[:3, 3] + moved)]
            found += [(f"laser of view {number}", laser + moved)]
        return found

    def view(self, number: int, seed: int) -> tuple[Hits, ViewMeasurement]:
        """Look from one viewpoint, or along one pass; there may be nothing to see."""
        tracer, pose = self.tracers[number // self.stations], self.poses[number]
        if self.passes:
            return profiler.scan_pass(tracer, self.passes[number % self.stations], pose, seed, number)
        hits = tracer.view(pose)
        if self.config.bounces == 1:
            return hits, measure(hits, tracer.config, seed, number)
        indirect = partial(brute_force.indirect, tracer, pose, seed=seed)
        return hits, measure(hits, tracer.config, seed, number, indirect)


def _assemble(rig: Rig, seed: int, views: list[tuple[Hits, ViewMeasurement]]) -> Scan:
    """Join the accepted points of all views in the mesh's frame and units."""
    shape, config, frame = rig.shape, rig.config, rig.tracer.frame
    accepted = [_accepted(*view, pose) for view, pose in zip(views, rig.poses, strict=True)]
    counts = [len(each["points"]) for each in accepted]
    profiler.check_seen(views, rig.passes, shape.name)
    _report(rig, views, counts)
    joined: dict[str, Any] = {name: np.concatenate([each[name] for each in accepted]) for name in accepted[0]}
    view_ids = np.repeat(np.arange(len(views), dtype=np.int32), counts)
    stations = view_ids % np.int32(rig.stations)  # two cameras of a rig are placed together
    joined["points"] = _aligned(frame.to_mesh(joined["points"]), stations, config, seed)
    poses = rig.poses.copy()
    poses[:, :3, 3] = frame.to_mesh(poses[:, :3, 3])
    found = Scan(
        **joined,
        true_points=shape.at(joined["face_ids"], joined["barycentrics"]),
        view_ids=view_ids,
        poses=poses,
        scale=frame.scale,
        shape_name=shape.name,
        config=config,
        seed=seed,
        variant=rig.tracer.variant,
    )
    if config.normals == "true":
        return found
    return replace(found, normals=estimated_normals(found, config.normals, config.neighbours))


def _accepted(hits: Hits, measured: ViewMeasurement, pose: NDArray[np.float64]) -> dict[str, NDArray[Any]]:
    """Attributes of a view's accepted points by their name in `Scan`; points and normals in the rig, mm."""
    mask = measured.verdict == Verdict.ACCEPTED
    hit = measured.index[mask]
    return {
        "points": measured.points[mask] @ pose[:3, :3].T + pose[:3, 3],
        "normals": hits.normals[hit] @ pose[:3, :3].T,
        "face_ids": hits.face_ids[hit],
        "barycentrics": hits.barycentrics[hit],
        "pixels": hits.pixels[hit],
        "intensity": measured.peak[mask],
        "width": measured.width[mask],
        "angle": measured.angle[mask],
    }


def _aligned(
    points: NDArray[np.float64], view_ids: NDArray[np.int32], config: ScannerConfig, seed: int
) -> NDArray[np.float64]:
    """Points with the error of bringing the views together, and with its repair, as configured."""
    if config.registration_error > 0:
        points = view_alignment.disturb(points, view_ids, config.registration_error, seed)
    if config.realign:
        points = view_alignment.realign(points, view_ids, seed)
    return points


def estimated_normals(scan: Scan, kind: str = "pca", neighbours: int = 12) -> NDArray[np.float64]:
    """Normals from the points of a scan, such as one thresholded or thinned out.

    Parameters
    ----------
    scan
    kind
        ``"pca"``: within each view, the scanner knowing the side; ``"pca_merged"``: the same over the
        points of all views; ``"pca_true_sign"``: the same with the side of the scan's normals, as in
        [BLN*11]; ``"mst"``: over all views, signs by a spanning tree and the scanner's votes, or the
        enclosed volume in a scan without viewpoints.
    neighbours
        Of each point.

    Returns
    -------
    (n, 3) float64
        Unit.

    Raises
    ------
    InputError
        If the kind is unknown, there are too few points, or signs from the scanner are asked of a scan
        without viewpoints.
    """
    kinds = ("pca", "pca_merged", "pca_true_sign", "mst")
    if kind not in kinds:
        raise InputError(f"normals can be estimated by {', '.join(map(repr, kinds))}, not {kind!r}")
    seen = bool((scan.view_ids >= 0).all())
    eyes = stations.eyes(scan) if seen else None
    if kind == "mst":
        found = normals.pca(scan.points, neighbours)
        return normals.spanning_tree(scan.points, found, neighbours, eyes)
    if kind == "pca_true_sign":
        found = normals.pca(scan.points, neighbours)
        return normals.toward(found, scan.points, scan.points + scan.normals)
    if eyes is None:
        raise InputError("this scan knows no viewpoints; estimate its normals with kind='mst'")
    if kind == "pca":
        found = normals.pca_by_view(scan.points, scan.view_ids, neighbours)
    else:
        found = normals.pca(scan.points, neighbours)
    return normals.toward(found, scan.points, eyes)


def _report(rig: Rig, views: list[tuple[Hits, ViewMeasurement]], counts: list[int]) -> None:
    """Raise InputError if nothing was acquired; log which views see nothing and which acquired nothing."""
    name = rig.shape.name
    if not sum(counts):
        configs = [rig.config_of(number) for number in range(len(views))]
        in_image = [shows((rig.tracer.vertices - p[:3, 3]) @ p[:3, :3], rig.config) for p in rig.poses]
        raise InputError(nothing_acquired(name, views, configs, in_image))
    blind = [number for number, (hits, _) in enumerate(views) if not (hits.face_ids >= 0).any()]
    if blind:
        _log.warning("%s: %d of %d views see nothing of it: %s", name, len(blind), len(views), blind)
    empty = [number for number, count in enumerate(counts) if count == 0 and number not in blind]
    if empty:
        _log.warning("%s: %d of %d views acquired no point: %s", name, len(empty), len(views), empty)


def facing_outward(shape: Shape) -> Shape:
    """The shape itself, or with reversed faces where it looks inward (`looks_inward`); says so in the log."""
    if len(shape.faces) == 0 or not looks_inward(shape.vertices, shape.faces):
        return shape
    _log.warning("%s: the faces look inward; scanned with outward normals", shape.name)
    return replace(shape, faces=np.ascontiguousarray(shape.faces[:, [0, 2, 1]]))


def _check(shape: Shape) -> None:
    """Raise InputError for shapes that cannot be traced; warn once of flat faces and of strange units."""
    if len(shape.faces) == 0 or len(shape.vertices) == 0:
        raise InputError(f"shape {shape.name!r} has no faces; scan a triangle mesh")
    if not np.isfinite(shape.vertices[shape.faces]).all():
        raise InputError(f"shape {shape.name!r} has vertices that are not finite; repair the mesh")
    flat = int((~solid_faces(shape.vertices, shape.faces)).sum())
    if flat == len(shape.faces):
        raise InputError(f"shape {shape.name!r} has no extent; scan a mesh with a surface")
    if flat:
        _warn_of_flat_faces(shape.subject, flat)
    side = float(np.ptp(shape.bounds, axis=0).max())
    if not 1e-3 <= side <= 1e5:
        _warn_of_units(shape.subject, side, shape.units)


@cache
def _warn_of_flat_faces(subject: str, count: int) -> None:
    """Once per subject and count."""
    _log.warning("%s: %d degenerate faces (no area) are ignored", subject, count)


@cache
def _warn_of_units(subject: str, side: float, units: str) -> None:
    """Once per subject and size."""
    size = f"{side:.3g} in unknown units" if units == "unknown" else f"{side:.3g} {units}"
    _log.warning("%s measures %s; the rig is scaled to it", subject, size)

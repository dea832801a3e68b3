"""One scan: views, stripes, peaks, triangulation."""

import logging
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.checks import edge_face_counts, signed_volume
from datasets_gen.meshes.geometry import winding_number
from datasets_gen.points import normals
from datasets_gen.records import InputError
from datasets_gen.shape import Shape
from scanner_sim import view_alignment
from scanner_sim.optics import viewpoints
from scanner_sim.optics.hits import Hits
from scanner_sim.optics.measurement import Verdict, ViewMeasurement, measure
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
        Triangle mesh in any units: the rig is scaled to it. A closed mesh whose faces look inward is
        scanned as if they looked outward.
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
        If the shape has no extent, a view sees nothing, or not a single point was acquired.
    """
    config = ScannerConfig() if config is None else config
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
    poses : (V, 4, 4) float64
        Camera-to-rig matrices, mm.
    """

    def __init__(self, shape: Shape, config: ScannerConfig, attributes: Attributes | None = None) -> None:
        _check(shape)
        self.shape = shape
        self.config = config
        self.tracer = Tracer(shape, config, attributes=attributes)
        half = self.tracer.frame.diagonal / 2
        distance = config.min_range + half if config.distance is None else config.distance
        self.poses = viewpoints.poses(viewpoints.directions(config.views, config.up), distance, config.up)
        if distance < half:
            self._check_outside()

    def _check_outside(self) -> None:
        """Raise InputError if a camera or laser stands inside the object."""
        for number, pose in enumerate(self.poses):
            laser = pose[:3, 3] + self.config.baseline * pose[:3, 0]
            for name, place in (("camera", pose[:3, 3]), ("laser", laser)):
                if winding_number(self.tracer.vertices[self.shape.faces], place) > 0.5:
                    raise InputError(
                        f"the {name} of view {number} stands inside {self.shape.name!r}; raise distance, now "
                        f"{self.config.distance} mm (the object's largest side: {self.config.object_size} mm)"
                    )

    def view(self, number: int, seed: int) -> tuple[Hits, ViewMeasurement]:
        """Look from one viewpoint.

        Raises
        ------
        InputError
            If no camera ray of the view hits the object.
        """
        hits = self.tracer.view(self.poses[number])
        if len(hits.face_ids) == 0:
            toward = np.round(self.poses[number][:3, 2], 3).tolist()
            raise InputError(
                f"view {number} (looking along {toward}) sees nothing of {self.shape.name!r}; "
                "leave it out of views or close the mesh"
            )
        rng = np.random.default_rng([seed, number])
        if self.config.bounces == 1:
            return hits, measure(hits, self.config, rng)
        indirect = partial(brute_force.indirect, self.tracer, self.poses[number], seed=seed)
        return hits, measure(hits, self.config, rng, indirect)


def _assemble(rig: Rig, seed: int, views: list[tuple[Hits, ViewMeasurement]]) -> Scan:
    """Join the accepted points of all views in the mesh's frame and units."""
    shape, config, frame = rig.shape, rig.config, rig.tracer.frame
    accepted = [_accepted(*view, pose) for view, pose in zip(views, rig.poses, strict=True)]
    counts = [len(each["points"]) for each in accepted]
    _report(shape, config, views, counts)
    joined: dict[str, Any] = {name: np.concatenate([each[name] for each in accepted]) for name in accepted[0]}
    view_ids = np.repeat(np.arange(len(views), dtype=np.int32), counts)
    joined["points"] = _aligned(frame.to_mesh(joined["points"]), view_ids, config, seed)
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
        ``"pca"``: within each view, the scanner knowing the side; ``"mst"``: signs by a spanning tree.
    neighbours
        Of each point.

    Returns
    -------
    (n, 3) float64
        Unit.

    Raises
    ------
    InputError
        If the kind is unknown, there are too few points, or ``"pca"`` is asked of a scan without viewpoints.
    """
    if kind == "mst":
        return normals.spanning_tree(scan.points, normals.pca(scan.points, neighbours), neighbours)
    if kind != "pca":
        raise InputError(f"normals can be estimated by 'pca' or 'mst', not {kind!r}")
    if (scan.view_ids < 0).any():
        raise InputError("this scan knows no viewpoints; estimate its normals with kind='mst'")
    found = normals.pca_by_view(scan.points, scan.view_ids, neighbours)
    return normals.toward(found, scan.points, scan.poses[scan.view_ids, :3, 3])


def _report(
    shape: Shape, config: ScannerConfig, views: list[tuple[Hits, ViewMeasurement]], counts: list[int]
) -> None:
    """Raise InputError if nothing was acquired, and log views that acquired nothing."""
    empty = [number for number, count in enumerate(counts) if count == 0]
    if empty and len(empty) < len(counts):
        _log.warning("%s: %d of %d views acquired no point: %s", shape.name, len(empty), len(counts), empty)
    if sum(counts):
        return
    depths = np.concatenate([hits.points[:, 2] for hits, _ in views])
    if depths.min() > config.max_range or depths.max() < config.min_range:
        raise InputError(
            f"{shape.name!r} lies at depths of {depths.min():.4g}..{depths.max():.4g} mm, outside the swept "
            f"{config.min_range:.4g}..{config.max_range:.4g} mm; change distance, min_range or max_range"
        )
    raise InputError(
        f"no point of {shape.name!r} was acquired from {len(views)} views at peak threshold "
        f"{config.peak_threshold}; lower it, add views or raise exposure or gain"
    )


def facing_outward(shape: Shape) -> Shape:
    """The shape itself, or with reversed faces where a closed mesh looks inward; says so in the log."""
    if len(shape.faces) == 0 or not signed_volume(shape.vertices, shape.faces) < 0:
        return shape
    if not (edge_face_counts(shape.faces) == 2).all():
        return shape
    _log.warning("%s: the faces look inward; scanned with outward normals", shape.name)
    return replace(shape, faces=np.ascontiguousarray(shape.faces[:, [0, 2, 1]]))


def _check(shape: Shape) -> None:
    """Raise InputError for shapes that cannot be traced; warn once of strange units."""
    if len(shape.faces) == 0 or len(shape.vertices) == 0:
        raise InputError(f"shape {shape.name!r} has no faces; scan a triangle mesh")
    if not np.isfinite(shape.vertices).all():
        raise InputError(f"shape {shape.name!r} has vertices that are not finite; repair the mesh")
    side = float(np.ptp(shape.vertices, axis=0).max())
    if side <= 0 or shape.area <= 0:
        raise InputError(f"shape {shape.name!r} has no extent; scan a mesh with a surface")
    if not 1e-3 <= side <= 1e5:
        _warn_of_units(shape.subject, side, shape.units)


@cache
def _warn_of_units(subject: str, side: float, units: str) -> None:
    """Once per subject and size."""
    _log.warning("%s measures %.3g %s; the rig is scaled to it", subject, side, units)

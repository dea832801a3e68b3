"""One scan: views, stripes, peaks, triangulation."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from datasets_gen.shape import Shape
from scanner_sim import peak, stripe, viewpoints
from scanner_sim.config import ScannerConfig
from scanner_sim.geometry import shading_normals
from scanner_sim.rays import Hits, Tracer, camera_rays
from scanner_sim.scan import Scan


def scan(shape: Shape, config: ScannerConfig | None = None, seed: int = 0) -> Scan:
    """Scan a shape with the laser-triangulation scanner of [BLN*11].

    Parameters
    ----------
    shape
        Closed mesh, any units: the rig is scaled to it.
    config
        The rig; ``ScannerConfig()`` if not given. To sweep thresholds, scan once at a low
        `peak_threshold` and use `Scan.accept`.
    seed
        Of the noise. Same shape, config and seed: same scan, whatever the number of threads.

    Returns
    -------
    Scan
        In the mesh's own frame and units.

    Raises
    ------
    InputError
        If the shape has no extent or not a single point was acquired.
    """
    config = ScannerConfig() if config is None else config
    _check(shape)
    tracer = Tracer(shape, config)
    toward = viewpoints.directions(config.views, config.up)
    poses = viewpoints.poses(toward, config.min_range + tracer.frame.diagonal / 2, config.up)
    rng = np.random.default_rng
    views = [
        _measure(tracer.view(pose), pose, config, rng([seed, number])) for number, pose in enumerate(poses)
    ]
    if not any(len(view.points) for view in views):
        raise InputError(
            f"no point of {shape.name!r} was acquired from {len(views)} views at peak threshold "
            f"{config.peak_threshold}; lower it, add views or check the mesh's orientation"
        )
    return _assemble(shape, config, seed, tracer, poses, views)


@dataclass(frozen=True)
class _View:
    """What one view acquired, in rig coordinates; arrays over its n points."""

    hits: Hits
    points: NDArray[np.float64]
    peak: NDArray[np.float64]
    width: NDArray[np.float64]
    angle: NDArray[np.float64]


def _measure(hits: Hits, pose: NDArray[np.float64], config: ScannerConfig, rng: np.random.Generator) -> _View:
    """Fit the peak of every lit pixel of a view and triangulate the accepted ones."""
    lit = np.flatnonzero(hits.radiance > 0)
    where = stripe.sheet(hits.points[lit], config.baseline)
    seen = stripe.samples(where, hits.radiance[lit], config, rng)
    peaks = peak.fit(seen.values, config.fit)
    angle = config.sweep[0] + (seen.first + peaks.position + 0.5) * config.step
    width = peaks.width * config.step
    cast = np.tan(config.wedge / 2) / 2 / where.ratio  # s of the profile that was cast
    kept = (
        (peaks.peak >= config.peak_threshold)
        & (peaks.residual <= config.residual_threshold)
        & (width <= config.std_threshold * cast)
        & (hits.points[lit, 2] >= config.min_range - 1e-6)
        & (hits.points[lit, 2] <= config.max_range + 1e-6)
    )
    index = lit[kept]
    chosen = Hits(
        hits.pixels[index],
        hits.face_ids[index],
        hits.barycentrics[index],
        hits.points[index],
        hits.radiance[index],
    )
    found = triangulate(camera_rays(chosen.pixels, config), angle[kept], config.baseline)
    return _View(chosen, found @ pose[:3, :3].T + pose[:3, 3], peaks.peak[kept], width[kept], angle[kept])


def triangulate(
    rays: NDArray[np.float64], angle: NDArray[np.float64], baseline: float
) -> NDArray[np.float64]:
    """Meet camera rays with laser planes.

    Parameters
    ----------
    rays : (n, 3)
        Directions from the camera with depth 1.
    angle : (n,)
        Sheet angles, radians: 0 along the viewing direction, positive to the right.
    baseline
        Of the laser along camera x.

    Returns
    -------
    (n, 3) float64
        Points in camera coordinates.
    """
    slope = np.tan(angle)  # the plane x = baseline + slope z
    return rays * (baseline / (rays[:, 0] - slope))[:, None]


def _assemble(
    shape: Shape,
    config: ScannerConfig,
    seed: int,
    tracer: Tracer,
    poses: NDArray[np.float64],
    views: list[_View],
) -> Scan:
    """Join the views in the mesh's frame and units."""
    face_ids = np.concatenate([v.hits.face_ids for v in views])
    barycentrics = np.concatenate([v.hits.barycentrics for v in views])
    placed = poses.copy()
    placed[:, :3, 3] = tracer.frame.to_mesh(poses[:, :3, 3])
    return Scan(
        points=tracer.frame.to_mesh(np.concatenate([v.points for v in views])),
        normals=shading_normals(shape, face_ids, barycentrics, config.shading),
        face_ids=face_ids,
        barycentrics=barycentrics,
        true_points=shape.at(face_ids, barycentrics),
        intensity=np.concatenate([v.peak for v in views]),
        view_ids=np.repeat(np.arange(len(views), dtype=np.int32), [len(v.points) for v in views]),
        pixels=np.concatenate([v.hits.pixels for v in views]),
        width=np.concatenate([v.width for v in views]),
        angle=np.concatenate([v.angle for v in views]),
        poses=placed,
        scale=tracer.frame.scale,
        shape_name=shape.name,
        config=config,
        seed=seed,
    )


def _check(shape: Shape) -> None:
    """Raise InputError for shapes that cannot be traced."""
    if len(shape.faces) == 0 or len(shape.vertices) == 0:
        raise InputError(f"shape {shape.name!r} has no faces; scan a triangle mesh")
    if not np.isfinite(shape.vertices).all():
        raise InputError(f"shape {shape.name!r} has vertices that are not finite; repair the mesh")
    if np.ptp(shape.vertices, axis=0).max() <= 0 or shape.area <= 0:
        raise InputError(f"shape {shape.name!r} has no extent; scan a mesh with a surface")

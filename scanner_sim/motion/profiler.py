"""The line profiler: a sheet that stands still in a moving rig, and a peak in every image row of every frame.

In each frame the camera sees the sheet's line on the object. The peak is looked for across the line, over the
columns of a row, instead of over time; the sub-pixel column and the known sheet give a point. Rows of a frame
are points of one profile, frames follow each other by `ScannerConfig.profile_step`. What the part does
meanwhile (`part_velocity`) the scanner does not know: points of a moving part are sheared.

A pass is handed on like a view of the sweeping scanner, with frames in the place of columns; positions and
widths of peaks are columns instead of angles. Where a row holds several lines, the brightest one counts.
"""

import math
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from scanner_sim.motion.line_image import LineRows, columns_per_radian, line_image, line_rows
from scanner_sim.motion.passes import MOST_FRAMES, Pass, lit_outline
from scanner_sim.optics import peak, stripe
from scanner_sim.optics.camera import camera_rays
from scanner_sim.optics.hits import Hits
from scanner_sim.optics.measurement import ViewMeasurement
from scanner_sim.optics.triangulation import triangulated
from scanner_sim.optics.verdict import FittedPeaks, judged
from scanner_sim.scanner_config import ScannerConfig
from scanner_sim.tracing.surface_points import barycentrics_on
from scanner_sim.tracing.tracer import Tracer

Array = NDArray[np.float64]


class Mesh(NamedTuple):
    """Vertices (v, 3) in camera coordinates, mm, and faces (f, 3)."""

    vertices: Array
    faces: NDArray[np.int32]


def scan_pass(tracer: Tracer, path: Pass, pose: Array, seed: int, view: int) -> tuple[Hits, ViewMeasurement]:
    """Measure every frame of a pass.

    Parameters
    ----------
    tracer
        Of the camera.
    path
    pose : (4, 4)
        Of the camera in frame 0.
    seed, view
        Identity of the sensor's noise.

    Returns
    -------
    Hits
        One for each frame and image row in which the camera sees the line: `pixels` are (frame, row),
        `points` lie on the resting part in coordinates of the camera in frame 0. There may be none.
    ViewMeasurement
        Of all of them, its `angle` and `width` in columns of the image.
    """
    found = [_profile(tracer, path, pose, frame, seed, view) for frame in range(path.frames)]
    seen = [each for each in found if each is not None]
    if not seen:
        nothing, verdict = np.empty(0), np.empty(0, np.int8)
        points, index = np.empty((0, 3)), np.empty(0, np.int64)
        return Hits.none(), ViewMeasurement(index, points, nothing, nothing, nothing, verdict)
    hits, measured = (_joined([each[k] for each in seen]) for k in (0, 1))
    measured["index"] = np.arange(len(hits["pixels"]))
    return Hits(**hits), ViewMeasurement(**measured)


def check_seen(views: list[tuple[Hits, ViewMeasurement]], passes: list[Pass], name: str) -> None:
    """Raise InputError if no camera saw the line on the object in any frame of any pass."""
    if passes and not any(len(hits.pixels) for hits, _ in views):
        frames = sum(path.frames for path in passes) * (len(views) // len(passes))
        raise InputError(
            f"the camera sees the laser's line on {name!r} in none of {frames} frames: it is in shadow or "
            "outside the image; change views, baseline or distance"
        )


def _joined(parts: list[Any]) -> dict[str, Any]:
    """Fields of several records one after the other."""
    return {f.name: np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(parts[0])}


def _profile(
    tracer: Tracer, path: Pass, pose: Array, frame: int, seed: int, view: int
) -> tuple[Hits, ViewMeasurement] | None:
    """One frame measured; None where the camera sees no line."""
    turn, config = pose[:3, :3], tracer.config
    seen_from = pose.copy()  # by the resting part
    seen_from[:3, 3] += frame * path.travel - path.part_shift(frame)
    angle = path.angle(pose)
    local = (tracer.vertices - seen_from[:3, 3]) @ turn
    outline = lit_outline(local, tracer.shape.faces, angle, config)
    if len(outline) == 0:
        return None
    hits = tracer.view(seen_from, outline)
    image = line_image(hits, angle, config)
    if image is None:
        return None
    line = line_rows(image, angle, config, seed, view * MOST_FRAMES + frame)
    hits, measured = _located(line, hits, Mesh(local, tracer.shape.faces), angle, config, frame)
    here = frame * path.travel @ turn  # from frame 0 to the camera of this one
    rest = here - path.part_shift(frame) @ turn
    truth = replace(hits, points=hits.points + rest)
    return truth, replace(measured, points=measured.points + here)


def _located(
    line: LineRows, hits: Hits, mesh: Mesh, angle: float, config: ScannerConfig, frame: int
) -> tuple[Hits, ViewMeasurement]:
    """Peaks, points and verdicts of the rows of a frame, and the truth; in coordinates of its camera."""
    peaks = peak.fit(line.values, config.fit, line.ceiling, 1 / columns_per_radian(angle, config))
    column = line.first + peaks.position
    points = triangulated(np.stack([column, line.rows], axis=1), np.full(len(column), angle), config)
    truth = _truth(line, peaks.position, hits, mesh, config)
    place = np.stack([np.full(len(column), frame), line.rows], axis=1).astype(np.int32)
    found = replace(truth, pixels=place)
    verdict = _verdicts(line, peaks, points, found, angle, config)
    return found, ViewMeasurement(np.arange(len(column)), points, peaks.peak, column, peaks.width, verdict)


def _truth(line: LineRows, position: Array, hits: Hits, mesh: Mesh, config: ScannerConfig) -> Hits:
    """Where the camera ray through each peak, between pixel centres, meets the object.

    Of the faces that the rays of the two nearest pixels hit, it is the one that the ray passes through or is
    nearer to. Without a peak, the ray of the first traced pixel counts.
    """
    offset = np.abs(np.arange(line.hit.shape[1]) - np.nan_to_num(position)[:, None])
    offset = np.where(line.hit < 0, np.inf, offset)
    rows = np.arange(len(position))
    nearest = offset.argmin(axis=1)
    here = line.first + np.where(np.isnan(position), nearest, position)
    rays = camera_rays(np.stack([here, line.rows], axis=1), config)
    best = np.full(len(rows), np.inf)
    index = line.hit[rows, nearest]
    barycentrics, places = hits.barycentrics[index], hits.points[index]
    for _ in range(2):
        ray = line.hit[rows, offset.argmin(axis=1)]
        faces = hits.face_ids[ray]
        weights, met = barycentrics_on(mesh.vertices[mesh.faces[np.maximum(faces, 0)]], rays)
        gap = np.linalg.norm(met / met[:, 2:] - rays, axis=1)
        better = (gap < best) & (ray >= 0) & (faces >= 0)
        best[better], index[better] = gap[better], ray[better]
        barycentrics[better], places[better] = weights[better], met[better]
        offset[rows, offset.argmin(axis=1)] = np.inf
    return Hits(
        hits.pixels[index],
        hits.face_ids[index],
        barycentrics,
        places,
        hits.normals[index],
        hits.radiance[index],
    )


def _verdicts(
    line: LineRows, peaks: peak.Peaks, points: Array, found: Hits, angle: float, config: ScannerConfig
) -> NDArray[np.int8]:
    """What becomes of each row, (n,)."""
    density = columns_per_radian(angle, config)
    if config.fit == "reference":
        widest = np.full(len(points), config.wedge / 2 * density)
    else:
        cast = stripe.cast_width(stripe.laser_coordinates(found.points, config.baseline), config)
        widest = np.hypot(cast * density, math.sqrt(2) * config.smoothing)
    fitted = FittedPeaks(
        peaks.peak,
        peaks.width,
        peaks.residual,
        peaks.accepted,
        config.std_threshold * widest,
        line.values.max(axis=1),
        (line.values >= line.ceiling[:, None] - 1e-9).sum(axis=1),
    )
    return judged(fitted, points, found.points, found.face_ids, config)

"""A white plane behind the object, square to the viewing direction: light that mixes in at silhouettes."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from datasets_gen.meshes.geometry import unit_vectors
from scanner_sim.optics.camera import camera_rays
from scanner_sim.optics.hits import Hits
from scanner_sim.scanner_config import ScannerConfig

FACE = -1
"""Face number of hits on the plane."""
SHORTENED = 1 - 1e-5
"""Part of the way that is tested, so that its end does not block it."""


def with_background(
    mi: Any,
    scene: Any,
    hits: Hits,
    rays: NDArray[np.int32],
    pose: NDArray[np.float64],
    config: ScannerConfig,
    fine: ScannerConfig,
) -> Hits:
    """Hits of a view, and those on the plane of the rays that miss the object.

    Only rays whose light can mix with that of the object are followed: those of pixels that show some of it
    and, where the image is blurred, of pixels within the reach of the blur.

    Parameters
    ----------
    mi
        Mitsuba with its variant set.
    scene
        Of the object alone.
    hits
        On the object.
    rays : (n, 2)
        Their pixels in the `fine` camera, which has one for every camera ray.
    pose : (4, 4)
        Camera-to-rig matrix, mm; the object's centre is the rig's origin.
    config, fine

    Returns
    -------
    Hits
        Those on the plane come last, with face number `FACE`.
    """
    depth = -float(pose[:3, 3] @ pose[:3, 2]) + (config.background or 0.0)
    missed = rays_beside(rays, config)
    if config.background is None or depth <= 0 or len(missed) == 0:
        return hits
    points = depth * camera_rays(missed, fine)
    laser = np.array([config.baseline, 0.0, 0.0])
    eye, place, ends = (x @ pose[:3, :3].T + pose[:3, 3] for x in (np.zeros((1, 3)), laser[None], points))
    seen = ~blocked(mi, scene, ends, eye)  # the backs of open meshes hide it
    missed, points, ends = missed[seen], points[seen], ends[seen]
    toward = laser - points
    lit = ~blocked(mi, scene, ends, place)
    radiance = np.where(lit, -toward[:, 2] / np.linalg.norm(toward, axis=1), 0.0)
    count = len(missed)
    return Hits(
        np.concatenate([hits.pixels, missed // np.int32(config.footprint)]),
        np.concatenate([hits.face_ids, np.full(count, FACE, hits.face_ids.dtype)]),
        np.concatenate([hits.barycentrics, np.zeros((count, 3))]),
        np.concatenate([hits.points, points]),
        np.concatenate([hits.normals, np.tile([0.0, 0.0, -1.0], (count, 1))]),
        np.concatenate([hits.radiance, radiance]),
    )


def rays_beside(rays: NDArray[np.int32], config: ScannerConfig) -> NDArray[np.int32]:
    """Camera rays that miss the object but whose light mixes with that of rays (n, 2) that hit it, (m, 2)."""
    side = config.footprint
    columns, rows = config.resolution
    near = np.zeros((rows, columns), bool)
    near[rays[:, 1] // side, rays[:, 0] // side] = True
    reach = int(np.ceil(3 * config.smoothing))
    near = maximum_filter(near, 2 * reach + 1, mode="constant")
    beside = np.repeat(np.repeat(near, side, axis=0), side, axis=1)
    beside[rays[:, 1], rays[:, 0]] = False
    row, column = np.nonzero(beside)
    return np.stack([column, row], axis=1).astype(np.int32)


def blocked(mi: Any, scene: Any, starts: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether the object stands between points (n, 3) and an end (1, 3), (n,); all in the rig."""
    away = end - starts
    length = np.linalg.norm(away, axis=1) * SHORTENED
    toward = unit_vectors(away)
    if mi.variant().startswith("scalar"):
        out = np.zeros(len(starts), bool)
        for k, (start, direction, reach) in enumerate(
            zip(starts.tolist(), toward.tolist(), length.tolist(), strict=True)
        ):
            ray = mi.Ray3f(mi.Point3f(start), mi.Vector3f(direction))
            ray.maxt = reach
            out[k] = scene.ray_test(ray)
        return out
    ray = mi.Ray3f(mi.Point3f(starts.T.astype(np.float32)), mi.Vector3f(toward.T.astype(np.float32)))
    ray.maxt = mi.Float(length.astype(np.float32))
    return np.array(scene.ray_test(ray)).astype(bool)

"""Every stripe rendered by Mitsuba with a real emitter: the slow truth that the synthesis is checked against.

A projector at the laser turns with the sheet and shines its profile. Unlike the synthesis this can follow
light that bounces between parts of the object (`ScannerConfig.bounces`).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scanner_sim.optics import stripe
from scanner_sim.optics.camera import visible_window
from scanner_sim.scanner_config import ScannerConfig
from scanner_sim.tracing import variant
from scanner_sim.tracing.scenes import build_scene, camera_sensor
from scanner_sim.tracing.tracer import Tracer

TEXELS = 512
"""Across the stripe; linear interpolation between them is wrong by 2e-5 of the peak."""
PATHS = 256
"""Light paths per pixel where light bounces."""


def indirect(
    tracer: Tracer,
    pose: NDArray[np.float64],
    pixels: NDArray[np.int32],
    swept: stripe.SweptStripes,
    seed: int = 0,
) -> NDArray[np.float64]:
    """Light that reaches pixels by more than one reflection, under the stripes of their rows.

    The difference of two renderings, so that the direct light stays synthesised.

    Parameters
    ----------
    tracer
    pose : (4, 4)
        Camera-to-rig matrix, mm.
    pixels : (m, 2)
    swept
        Stripes of each pixel, (m, w).
    seed
        Of the light paths.

    Returns
    -------
    (m, w) float64
        In units of the direct light: 1 is a white surface that faces the laser at the nearest depth.
    """
    config = tracer.config
    numbers = np.arange(config.stripes)
    more, one = (render(tracer, pose, pixels, numbers, b, PATHS, seed) for b in (config.bounces, 1))
    gain = config.nearest**2 * np.maximum(more - one, 0)
    column = swept.first[:, None] + np.arange(swept.values.shape[1])
    inside = (column >= 0) & (column < config.stripes)
    values = np.take_along_axis(gain, np.clip(column, 0, config.stripes - 1), axis=1)
    return np.where(inside, values, 0.0)


def render(
    tracer: Tracer,
    pose: NDArray[np.float64],
    pixels: NDArray[np.int32],
    numbers: NDArray[np.integer],
    bounces: int = 1,
    paths: int = 1,
    seed: int = 0,
) -> NDArray[np.float64]:
    """Radiance of pixels under single stripes of the wedge of irradiance pi at distance 1.

    Parameters
    ----------
    tracer
    pose : (4, 4)
        Camera-to-rig matrix, mm.
    pixels : (m, 2)
    numbers : (k,)
        Of the stripes.
    bounces
        Reflections followed.
    paths
        Light paths per pixel; a single one goes through the pixel's centre, more cover its area.
    seed
        Of the light paths.

    Returns
    -------
    (m, k) float64
        For one bounce and path: BSDF times cosine times profile times pi, over the squared distance to
        the laser.
    """
    config = tracer.config
    vertices = (tracer.vertices - pose[:3, 3]) @ pose[:3, :3]
    window = visible_window(vertices, config)
    out = np.zeros((len(pixels), len(numbers)))
    if window is None or len(pixels) == 0:
        return out
    row, column = pixels[:, 1] - window[1], pixels[:, 0] - window[0]
    with variant.active(tracer.variant) as mi:
        mesh = tracer.mesh(mi)
        scene = build_scene(mi, mesh, _projector(mi, config, _tallest(vertices, config)))
        parameters = mi.traverse(scene)
        camera = camera_sensor(mi, config, pose, window, paths)
        integrator = mi.load_dict({"type": "path", "max_depth": bounces + 1, "rr_depth": bounces + 2})
        for k, number in enumerate(numbers):
            theta = config.sweep[0] + (number + 0.5) * config.step
            place = _turned(pose, config.baseline, theta)
            parameters["laser.to_world"] = mi.AffineTransform4f(place.tolist())
            parameters.update()
            image = np.array(integrator.render(scene, sensor=camera, seed=seed))[..., 0]
            out[:, k] = image[row, column]
    return out


def _tallest(vertices: NDArray[np.float64], config: ScannerConfig) -> float:
    """Largest tangent of the object's elevation seen from the laser."""
    laser = stripe.laser_coordinates(vertices, config.baseline)
    return 1.02 * float(np.max(np.abs(vertices[:, 1]) / laser.axis_distance))


def _projector(mi: Any, config: ScannerConfig, tallest: float) -> dict[str, Any]:
    """Emitter that shines the wedge's profile, with irradiance pi at distance 1 on the sheet.

    Mitsuba's projector falls off with pi / (z^2 cos): the texture undoes all of it but pi / r^2.
    """
    edge = np.tan(config.wedge / 2)
    height = int(np.ceil(TEXELS * tallest / edge))
    u = ((np.arange(TEXELS) + 0.5) / TEXELS * 2 - 1) * edge
    v = ((np.arange(height) + 0.5) / height * 2 - 1) * edge * height / TEXELS
    length = np.sqrt(1 + u[None, :] ** 2 + v[:, None] ** 2)
    ratio = np.sqrt(1 + u[None, :] ** 2) / length
    profile = stripe.wedge(np.arctan(u)[None, :], ratio, config.wedge) / length**3
    texture = {"type": "bitmap", "bitmap": mi.Bitmap(profile.astype(np.float32)[..., None]), "raw": True}
    texture["wrap_mode"] = "clamp"
    return {
        "type": "projector",
        "irradiance": texture,
        "fov": float(np.degrees(config.wedge)),
        "fov_axis": "x",
    }


def _turned(pose: NDArray[np.float64], baseline: float, theta: float) -> NDArray[np.float64]:
    """Laser-to-rig matrix of the sheet at an angle, in Mitsuba's convention (x left, y up, z forward)."""
    turn = np.eye(4)
    turn[[0, 0, 2, 2], [0, 2, 0, 2]] = np.cos(theta), np.sin(theta), -np.sin(theta), np.cos(theta)
    shift = np.eye(4)
    shift[0, 3] = baseline
    return pose @ shift @ turn @ np.diag([-1.0, -1.0, 1.0, 1.0])

"""Triangulation: a pixel's camera ray meets the plane of the laser sheet that lit it."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scanner_sim.optics import calibration
from scanner_sim.optics.camera import camera_rays
from scanner_sim.scanner_config import ScannerConfig


def triangulate(
    rays: NDArray[np.float64], angle: NDArray[np.float64], baseline: float
) -> NDArray[np.float64]:
    """Intersect camera rays with planes of the laser sheet.

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
        Points in camera coordinates, in the units of the baseline; not finite where a ray is parallel to its
        plane.
    """
    slope = np.tan(angle)  # the plane x = baseline + slope z
    return rays * (baseline / (rays[:, 0] - slope))[:, None]


def triangulated(
    pixels: NDArray[Any], angle: NDArray[np.float64], config: ScannerConfig
) -> NDArray[np.float64]:
    """Points of pixels and the sheet angles that lit them, as the calibrated scanner computes them.

    Parameters
    ----------
    pixels : (n, 2)
        Column and row; whole numbers are pixel centres, fractions lie between them.
    angle : (n,)
        Angles that the sheet had, radians.
    config
        Of the camera: for the second one that of `viewpoints.second_camera`.

    Returns
    -------
    (n, 3) float64
        In camera coordinates, mm, with the errors of calibration.
    """
    rays = camera_rays(calibration.assumed_pixels(pixels, config), config)
    return triangulate(rays, calibration.assumed_angle(angle, config), calibration.assumed_baseline(config))

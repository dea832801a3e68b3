"""Errors of calibration: the rig that the scanner believes it has, and what that does to depths.

The rig itself is that of `ScannerConfig`; pixels and peaks come from it. Only triangulation works with what a
calibration found: another focal length, principal point, baseline and sheet angle. With ``u = x / z`` of the
camera ray and ``t = tan(theta)`` of the sheet, depth is ``z = b / (u - t)``; the first-order errors below are
its derivatives, cf. [Bla04].

[Bla04] F. Blais, "Review of 20 years of range sensor development", Journal of Electronic Imaging 13(1), 2004.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scanner_sim.scanner_config import ScannerConfig

Values = NDArray[np.float64]


def assumed_pixels(pixels: NDArray[Any], config: ScannerConfig) -> NDArray[Any]:
    """Where a pixel would lie on a camera without error whose ray is the one that the calibration gives it.

    With focal length ``f (1 + e)`` and principal point ``c + d``, the point u of the image has the normalised
    coordinate ``(u - c - d) / (f (1 + e))``, which belongs to the point ``c + (u - c - d) / (1 + e)``.

    Parameters
    ----------
    pixels : (n, 2)
        Column and row; fractions of pixels too.
    config

    Returns
    -------
    (n, 2)
        The pixels themselves if the intrinsics have no error.
    """
    if config.focal_error == 0 and not any(config.principal_point_error):
        return pixels
    centre = np.array(config.resolution) / 2 - 0.5
    offset = pixels - centre - np.array(config.principal_point_error)
    return np.asarray(centre + offset / (1 + config.focal_error))


def assumed_angle(angle: Values, config: ScannerConfig) -> Values:
    """Sheet angles that the scanner reads from its encoder, radians, of those that the sheet has."""
    return angle if config.sheet_error == 0 else angle + math.radians(config.sheet_error)


def assumed_baseline(config: ScannerConfig) -> float:
    """Baseline that the calibration found, mm."""
    return config.baseline + config.baseline_error


def baseline_depth_error(depth: Values, baseline: float, error: float) -> Values:
    """``dz = z db / b``: the whole view is scaled about the camera; exact, not of first order only."""
    return depth * error / baseline


def sheet_depth_error(depth: Values, angle: Values, baseline: float, error: float) -> Values:
    """``dz = z^2 dtheta / (b cos^2 theta)``, angles in radians."""
    return depth**2 * error / (baseline * np.cos(angle) ** 2)


def principal_point_depth_error(depth: Values, baseline: float, focal: float, error: float) -> Values:
    """``dz = z^2 d / (b f)`` of an error of d pixels along the columns; that along the rows leaves depths."""
    return depth**2 * error / (baseline * focal)


def focal_depth_error(x: Values, depth: Values, baseline: float, error: float) -> Values:
    """``dz = z x e / b`` of the relative error e: none in the middle column, opposite on its two sides."""
    return depth * x * error / baseline


def depth_error(points: Values, config: ScannerConfig) -> Values:
    """Errors of depth that the configured errors of calibration cause together, to first order.

    Parameters
    ----------
    points : (n, 3)
        True ones, in camera coordinates, mm. Distortion of the lens is left out.
    config

    Returns
    -------
    (n,) float64
        Measured less true depth, mm.
    """
    x, z = points[:, 0], points[:, 2]
    angle = np.arctan2(x - config.baseline, z)
    return (
        baseline_depth_error(z, config.baseline, config.baseline_error)
        + sheet_depth_error(z, angle, config.baseline, math.radians(config.sheet_error))
        + principal_point_depth_error(z, config.baseline, config.focal, config.principal_point_error[0])
        + focal_depth_error(x, z, config.baseline, config.focal_error)
    )

"""Radiometry of the moving laser sheet: how much of each stripe falls on each surface point."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scanner_sim.scanner_config import ScannerConfig

BEAM_CUT = 2.15
"""Gaussian beams are cut at this many 1/e^2 radii, where they carry 1e-4 of their peak."""


@dataclass(frozen=True)
class LaserCoordinates:
    """Surface points in the laser's coordinates.

    Attributes
    ----------
    angle : (n,) float64
        phi: sheet angle that meets the point, radians.
    axis_distance : (n,) float64
        rho: distance from the axis about which the sheet turns, mm.
    distance : (n,) float64
        r: distance from the laser, mm.
    """

    angle: NDArray[np.float64]
    axis_distance: NDArray[np.float64]
    distance: NDArray[np.float64]


def laser_coordinates(points: NDArray[np.float64], baseline: float) -> LaserCoordinates:
    """Laser coordinates of points.

    Parameters
    ----------
    points : (n, 3)
        In camera coordinates, mm.
    baseline
        Distance of the laser from the camera, to the right, mm.
    """
    x, y, z = points[:, 0] - baseline, points[:, 1], points[:, 2]
    axis = np.hypot(x, z)
    return LaserCoordinates(np.arctan2(x, z), axis, np.hypot(axis, y))


def wedge(
    offset: NDArray[np.float64], ratio: NDArray[np.float64] | float, angle: float
) -> NDArray[np.float64]:
    r"""Relative radiance of the reference's stripe.

    ``L = exp(-2 (rho sin(theta - phi))^2 / (r tan(F/2) / 2)^2)`` within the wedge, 0 outside [BLN*11].

    Parameters
    ----------
    offset
        theta - phi, radians.
    ratio
        rho / r, broadcast against `offset`.
    angle
        Full angle F, radians.

    Returns
    -------
    float64, of the shape of `offset`
        In [0, 1].
    """
    inside = np.abs(offset) <= angle / 2
    return np.where(inside, np.exp(-8 * (ratio * np.sin(offset) / math.tan(angle / 2)) ** 2), 0.0)


def gaussian(
    offset: NDArray[np.float64],
    axis: NDArray[np.float64] | float,
    radius: NDArray[np.float64] | float,
    waist: float,
) -> NDArray[np.float64]:
    r"""Relative radiance of a Gaussian beam: ``(w0 / w) exp(-2 (rho sin(theta - phi))^2 / w^2)``.

    Parameters
    ----------
    offset
        theta - phi, radians.
    axis, radius
        rho and the beam's 1/e^2 radius w there (`beam_radius`), mm; broadcast against `offset`.
    waist
        w0, mm.

    Returns
    -------
    float64, of the shape of `offset`
        At most 1, which it reaches in the waist.
    """
    across = axis * np.sin(offset) / radius
    return np.where(np.abs(across) <= BEAM_CUT, waist / radius * np.exp(-2 * across**2), 0.0)


def beam_radius(distance: NDArray[np.float64], config: ScannerConfig) -> NDArray[np.float64]:
    """1/e^2 radius w of the beam: ``w0 sqrt(1 + ((r - focus) / z_R)^2)``, ``z_R = pi w0^2 / lambda``."""
    rayleigh = math.pi * config.beam_waist**2 / (config.wavelength * 1e-6)
    return config.beam_waist * np.hypot(1, (distance - config.focus) / rayleigh)


def light(offset: NDArray[np.float64], laser: LaserCoordinates, config: ScannerConfig) -> NDArray[np.float64]:
    """Relative radiance of stripes at points, without falloff.

    Parameters
    ----------
    offset : (n, w)
        theta - phi, radians.
    laser
        Laser coordinates of n points.
    config
    """
    if config.beam == "wedge":
        return wedge(offset, (laser.axis_distance / laser.distance)[:, None], config.wedge)
    radius = beam_radius(laser.distance, config)
    return gaussian(offset, laser.axis_distance[:, None], radius[:, None], config.beam_waist)


def half_angle(laser: LaserCoordinates, config: ScannerConfig) -> NDArray[np.float64]:
    """Largest theta - phi that lights each point, radians, (n,)."""
    if config.beam == "wedge":
        return np.full(len(laser.angle), config.wedge / 2)
    return np.arcsin(np.minimum(BEAM_CUT * beam_radius(laser.distance, config) / laser.axis_distance, 1))


def cast_width(laser: LaserCoordinates, config: ScannerConfig) -> NDArray[np.float64]:
    """Width s of the peak ``exp(-(theta - phi)^2 / s^2)`` that the sheet casts, radians, (n,).

    For the wedge in the horizontal plane of the laser ``s / F = 1 / sqrt 32 = .1768``.
    """
    if config.beam == "wedge":
        return math.tan(config.wedge / 2) / math.sqrt(8) * laser.distance / laser.axis_distance
    return beam_radius(laser.distance, config) / (math.sqrt(2) * laser.axis_distance)


def falloff(laser: LaserCoordinates, config: ScannerConfig) -> NDArray[np.float64]:
    """Irradiance relative to that at the nearest depth swept, in front of the camera, (n,)."""
    if config.falloff == "none":
        return np.ones(len(laser.distance))
    return (config.nearest / laser.distance) ** 2


@dataclass(frozen=True)
class SweptStripes:
    """Stripes that may light each point.

    Attributes
    ----------
    first : (n,) int64
        Number of the first stripe of the row.
    values : (n, w) float64
        Per stripe; 0 where it does not light the point.
    """

    first: NDArray[np.int64]
    values: NDArray[np.float64]


def swept_stripes(laser: LaserCoordinates, config: ScannerConfig, margin: float = 0.0) -> SweptStripes:
    """Relative radiance of every stripe near each point.

    Parameters
    ----------
    laser
        Laser coordinates of n points.
    config
    margin
        Angle by which the row of stripes is longer at both ends, radians.
    """
    half = half_angle(laser, config) + margin
    start, _ = config.sweep
    first = np.ceil((laser.angle - half - start) / config.step - 0.5).astype(np.int64)
    span = int(np.ceil(2 * half.max(initial=0) / config.step)) + 1
    offset, inside = offsets(first, span, laser.angle, config)
    return SweptStripes(first, np.where(inside, light(offset, laser, config), 0.0))


def offsets(
    first: NDArray[np.int64], span: int, angle: NDArray[np.float64], config: ScannerConfig
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Angles theta - phi of a row of stripes, (n, span) radians, and whether the sweep has such a stripe."""
    number = first[:, None] + np.arange(span)
    theta = config.sweep[0] + (number + 0.5) * config.step
    return theta - angle[:, None], (number >= 0) & (number < config.stripes)

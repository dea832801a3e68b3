"""Radiometry of the moving laser sheet: what each pixel sees of each stripe."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scanner_sim.config import ScannerConfig


@dataclass(frozen=True)
class Sheet:
    """Surface points in the laser's coordinates.

    Attributes
    ----------
    angle : (n,) float64
        phi: sheet angle that meets the point, radians.
    ratio : (n,) float64
        rho / r: distance from the laser's axis over distance from the laser; 1 on the rig's plane.
    """

    angle: NDArray[np.float64]
    ratio: NDArray[np.float64]


def sheet(points: NDArray[np.float64], baseline: float) -> Sheet:
    """Laser coordinates of points in camera coordinates, (n, 3) mm."""
    x, y, z = points[:, 0] - baseline, points[:, 1], points[:, 2]
    axis = np.hypot(x, z)
    return Sheet(np.arctan2(x, z), axis / np.hypot(axis, y))


def profile(offset: NDArray[np.float64], ratio: NDArray[np.float64], wedge: float) -> NDArray[np.float64]:
    r"""Relative radiance of a stripe, the equation of [BLN*11] in our words.

    ``L = exp(-2 (rho sin(theta - phi))^2 / (r tan(F/2) / sqrt 2)^2)`` within the wedge, 0 outside.

    Parameters
    ----------
    offset
        theta - phi, radians.
    ratio
        rho / r, broadcast against `offset`.
    wedge
        Full angle F, radians.
    """
    inside = np.abs(offset) <= wedge / 2
    return np.where(inside, np.exp(-4 * (ratio * np.sin(offset) / np.tan(wedge / 2)) ** 2), 0.0)


@dataclass(frozen=True)
class Samples:
    """Intensities of each pixel over the stripes that may light it.

    Attributes
    ----------
    first : (n,) int64
        Number of the first stripe of the row.
    values : (n, w) float64
        Camera intensity per stripe; 0 where the stripe does not light the pixel.
    """

    first: NDArray[np.int64]
    values: NDArray[np.float64]


def samples(
    where: Sheet, amplitude: NDArray[np.float64], config: ScannerConfig, rng: np.random.Generator
) -> Samples:
    """Camera intensities ``quantise(L * amplitude - noise)`` of every stripe near each point.

    Parameters
    ----------
    where
        The points, n of them.
    amplitude : (n,)
        Reflected share: cosine times albedo; 0 in shadow.
    config
    rng
        Source of the noise.
    """
    span = int(np.ceil(config.wedge / config.step)) + 1
    start, _ = config.sweep
    first = np.ceil((where.angle - config.wedge / 2 - start) / config.step - 0.5).astype(np.int64)
    number = first[:, None] + np.arange(span)
    theta = start + (number + 0.5) * config.step
    cast = profile(theta - where.angle[:, None], where.ratio[:, None], config.wedge)
    cast[(number < 0) | (number >= config.stripes)] = 0
    values = cast * amplitude[:, None]
    if config.noise > 0:
        values = values - speckle(cast, config.noise, rng)
    return Samples(first, quantise(values, config.bits))


def speckle(cast: NDArray[np.float64], magnitude: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Additive noise ``min(L, A) exp(-2 z^2)``, z normal: what is taken from the intensity."""
    return np.minimum(cast, magnitude) * np.exp(-2 * rng.standard_normal(cast.shape) ** 2)


def quantise(values: NDArray[np.float64], bits: int) -> NDArray[np.float64]:
    """Clip to [0, 1] and round to ``2**bits - 1`` steps; 0 bits only clip."""
    clipped = np.clip(values, 0, 1)
    if bits == 0:
        return clipped
    levels = 2**bits - 1
    return np.round(clipped * levels) / levels

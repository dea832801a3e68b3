"""The image of a sheet's line in one frame of the profiler, and samples across it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d

from scanner_sim.optics import peak, sensor, stripe
from scanner_sim.optics.blur import kernel
from scanner_sim.optics.contributions import contributions
from scanner_sim.optics.hits import Hits
from scanner_sim.optics.noise import SampleNoise
from scanner_sim.scanner_config import ScannerConfig

REACH = 1.5
"""Half widths of the line, on a surface that faces the camera, to each side of a row's brightest sample."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LineImage:
    """Light of a part of the image, with a margin that the camera does not see around it.

    Attributes
    ----------
    corner : (int, int)
        Column and row of the first pixel.
    light, cast, ambient : (h, w) float64
        As for `sensor.expose`.
    hit : (h, w) int64
        A camera ray of each pixel, the brightest; -1 where there is none.
    """

    corner: tuple[int, int]
    light: Array
    cast: Array
    ambient: Array
    hit: NDArray[np.int64]


@dataclass(frozen=True)
class LineRows:
    """Samples across the line.

    Attributes
    ----------
    rows, first : (n,) int64
        Image row, and column of the first sample.
    values : (n, w) float64
        Intensities of neighbouring columns.
    ceiling : (n,) float64
        Intensity at which the row saturates.
    hit : (n, w) int64
        A camera ray of each sample's pixel; -1 where there is none.
    """

    rows: NDArray[np.int64]
    first: NDArray[np.int64]
    values: Array
    ceiling: Array
    hit: NDArray[np.int64]


def columns_per_radian(angle: float, config: ScannerConfig) -> float:
    """Columns by which the line on a surface that faces the camera moves per angle of the sheet.

    At the depth z it lies at ``x = b + z tan(theta)``, so ``du/dtheta = f / cos^2 theta``, whatever z.
    """
    return config.focal / math.cos(angle) ** 2


def line_image(hits: Hits, angle: float, config: ScannerConfig) -> LineImage | None:
    """Light of the sheet on the traced pixels; None if no pixel is lit.

    Parameters
    ----------
    hits
        Of a frame, in coordinates of its camera.
    angle
        Of the sheet, radians.
    config
    """
    lit = contributions(hits, config)
    cast = stripe.light((angle - lit.laser.angle)[:, None], lit.laser, config)[:, 0]
    light = cast * lit.amplitude
    if not (light > peak.FLOOR).any():
        return None
    margin = _reach(angle, config) + (len(kernel(config.smoothing)) if config.smoothing else 0)
    corner = hits.pixels.min(axis=0) - margin
    width, height = hits.pixels.max(axis=0) + margin + 1 - corner
    x, y = (hits.pixels - corner).T.astype(np.int64)
    place = y * width + x

    def total(values: Array) -> Array:
        summed = np.bincount(place[lit.hit], values, minlength=height * width)
        return np.asarray(summed.reshape(height, width))

    brightness = np.bincount(lit.hit, light, minlength=len(place))
    hit = np.full(height * width, -1)
    order = np.argsort(brightness, kind="stable")
    hit[place[order]] = order  # of several, the last
    images = total(light), total(cast * lit.share), total(lit.ambient)
    return LineImage((int(corner[0]), int(corner[1])), *images, hit.reshape(height, width))


def _reach(angle: float, config: ScannerConfig) -> int:
    """Samples of a row on each side of the brightest one."""
    laser = stripe.LaserCoordinates(np.zeros(1), np.array([config.focus]), np.array([config.focus]))
    half = float(stripe.half_angle(laser, config)[0]) * columns_per_radian(angle, config)
    return max(2, math.ceil(REACH * half + 2 * config.smoothing))


def line_rows(image: LineImage, angle: float, config: ScannerConfig, seed: int, view: int) -> LineRows:
    """Samples across the brightest line of every lit row, as the sensor stores them.

    Parameters
    ----------
    image
    angle
        Of the sheet, radians.
    config
    seed, view
        Identity of the noise of this frame.
    """
    height, width = image.light.shape
    light, cast = image.light, image.cast
    if config.smoothing > 0 and config.smoothing_stage == "light":
        light, cast = _blurred(light, config), _blurred(cast, config)
    row, column = np.divmod(np.arange(height * width), width)
    column, row = column + image.corner[0], row + image.corner[1]
    inside = (column >= 0) & (column < config.resolution[0]) & (row >= 0) & (row < config.resolution[1])
    noise = SampleNoise(
        seed, view, np.stack([column, row], axis=1).astype(np.int32), np.zeros(len(row), np.int64), 1
    )
    flat = light.reshape(-1, 1), cast.reshape(-1, 1), image.ambient.ravel()
    stored, ceiling = sensor.expose(*flat, config, noise)
    values = np.where(inside[:, None], stored, 0).reshape(height, width)
    if config.smoothing > 0 and config.smoothing_stage == "image":
        values = _blurred(values, config)
    seen = np.where(inside.reshape(height, width), light, 0)
    lit = np.flatnonzero(seen.max(axis=1) > peak.FLOOR)
    reach = _reach(angle, config)
    first = np.clip(seen[lit].argmax(axis=1) - reach, 0, width - 2 * reach - 1)
    samples = first[:, None] + np.arange(2 * reach + 1)
    return LineRows(
        lit + image.corner[1],
        first + image.corner[0],
        values[lit[:, None], samples],
        ceiling.reshape(height, width)[lit[:, None], samples].min(axis=1),
        image.hit[lit[:, None], samples],
    )


def _blurred(image: Array, config: ScannerConfig) -> Array:
    """An image after Gaussian blur of its pixels."""
    weights = kernel(config.smoothing)
    for axis in (0, 1):
        image = correlate1d(image, weights, axis=axis, mode="constant")
    return image

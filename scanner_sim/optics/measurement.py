"""One view measured: intensities over time, fitted peaks, triangulated points, a verdict on every pixel."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from scanner_sim.optics import peak, sensor, stripe
from scanner_sim.optics.camera import camera_rays
from scanner_sim.optics.hits import Hits
from scanner_sim.optics.triangulation import triangulate
from scanner_sim.scanner_config import ScannerConfig

SATURATED_SAMPLES = 3
"""A pixel whose peak is rejected counts as saturated if this many of its samples are."""

Indirect = Callable[[NDArray[np.int32], stripe.SweptStripes], NDArray[np.float64]]
"""Light by more than one reflection, (m, w), of pixels (m, 2) under the stripes of their rows."""


class Verdict(IntEnum):
    """What became of a pixel."""

    MISS = 0
    """The camera ray misses the object."""
    ACCEPTED = 1
    SHADOW = 2
    """The surface faces the laser, but something is in between."""
    GRAZING = 3
    """The surface faces away from the laser, or so obliquely that a white one would be too dark."""
    DARK = 4
    """Too little light returns for another reason: material, falloff, noise."""
    SATURATED = 5
    """Too much light returns to locate the peak."""
    OUT_OF_RANGE = 6
    """Nearer or farther than the depths swept."""
    POOR_FIT = 7
    """No Gaussian, or one too wide, too far from the samples or from the true depth."""


@dataclass(frozen=True)
class ViewMeasurement:
    """The m lit pixels of a view.

    Attributes
    ----------
    index : (m,) int64
        Into the view's hits.
    points : (m, 3) float64
        Triangulated, in camera coordinates, mm; not finite without a peak.
    peak, angle, width : (m,) float64
        Of the fit; angles in radians.
    verdict : (m,) int8
        `Verdict` of each.
    """

    index: NDArray[np.int64]
    points: NDArray[np.float64]
    peak: NDArray[np.float64]
    angle: NDArray[np.float64]
    width: NDArray[np.float64]
    verdict: NDArray[np.int8]


def measure(
    hits: Hits,
    config: ScannerConfig,
    rng: np.random.Generator,
    indirect: Indirect | None = None,
) -> ViewMeasurement:
    """Fit the peak of every lit pixel of a view and triangulate it.

    Parameters
    ----------
    hits
    config
    rng
        Source of the sensor's noise.
    indirect
        Gives light that arrives by more than one reflection, for pixels and their stripes.

    Returns
    -------
    ViewMeasurement
        Of the hits that the laser reaches.
    """
    index = np.flatnonzero(hits.radiance > 0)
    laser = stripe.laser_coordinates(hits.points[index], config.baseline)
    first, values = intensities(hits, index, laser, config, rng, indirect)
    return _fitted(hits, index, laser, first, values, config)


def intensities(
    hits: Hits,
    index: NDArray[np.int64],
    laser: stripe.LaserCoordinates,
    config: ScannerConfig,
    rng: np.random.Generator,
    indirect: Indirect | None = None,
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Camera intensities over time of the lit pixels.

    Parameters
    ----------
    hits
    index : (m,)
        The lit ones among the hits.
    laser
        Their laser coordinates.
    config
    rng
        Source of the sensor's noise.
    indirect
        As for `measure`.

    Returns
    -------
    first : (m,) int64
        Number of the first stripe of each row.
    values : (m, w) float64
        Stored intensities under it and the stripes that follow.
    """
    amplitude = hits.radiance[index] * stripe.falloff(laser, config)
    pixels = hits.pixels[index]
    margin = 3 * config.smoothing / config.focal + (config.wedge / 2 if indirect else 0)
    swept = stripe.swept_stripes(laser, config, margin)
    light = swept.values * amplitude[:, None]
    if config.smoothing > 0:
        light = blurred(pixels, amplitude, laser, swept, config)
    if indirect is not None:
        light = light + indirect(pixels, swept)
    return swept.first, sensor.expose(light, swept.values, config, rng)


def blurred(
    pixels: NDArray[np.int32],
    amplitude: NDArray[np.float64],
    laser: stripe.LaserCoordinates,
    swept: stripe.SweptStripes,
    config: ScannerConfig,
) -> NDArray[np.float64]:
    """Light of every stripe near each pixel after each stripe's image was blurred, (m, w).

    Every pixel gathers the light of its neighbours, weighted by the Gaussian; unlit ones give none.
    """
    reach = int(np.ceil(3 * config.smoothing))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / config.smoothing) ** 2)
    weights /= weights.sum()
    columns, rows = config.resolution
    place = np.full((rows + 2 * reach, columns + 2 * reach), -1, np.int64)
    place[pixels[:, 1] + reach, pixels[:, 0] + reach] = np.arange(len(pixels))
    total = np.zeros_like(swept.values)
    for dy in range(2 * reach + 1):
        for dx in range(2 * reach + 1):
            other = place[pixels[:, 1] + dy, pixels[:, 0] + dx]
            here = np.flatnonzero(other >= 0)
            q = other[here]
            source = stripe.LaserCoordinates(laser.angle[q], laser.axis_distance[q], laser.distance[q])
            offset, inside = stripe.offsets(swept.first[here], total.shape[1], source.angle, config)
            cast = np.where(inside, stripe.light(offset, source, config), 0)
            total[here] += weights[dy] * weights[dx] * amplitude[q, None] * cast
    return total


def _fitted(
    hits: Hits,
    index: NDArray[np.int64],
    laser: stripe.LaserCoordinates,
    first: NDArray[np.int64],
    values: NDArray[np.float64],
    config: ScannerConfig,
) -> ViewMeasurement:
    """Peaks, points and verdicts of intensities over time."""
    peaks = peak.fit(values, config.fit)
    angle = config.sweep[0] + (first + peaks.position + 0.5) * config.step
    width = peaks.width * config.step
    points = triangulate(camera_rays(hits.pixels[index], config), angle, config.baseline)
    truth = hits.points[index]
    fitting = (peaks.residual <= config.residual_threshold) & (points[:, 2] > 0)
    fitting &= width <= config.std_threshold * stripe.cast_width(laser, config)
    if config.depth_threshold is not None:
        fitting &= np.linalg.norm(points - truth, axis=1) <= config.depth_threshold
    faint = np.isnan(peaks.peak) & (values.max(axis=1, initial=0) < config.peak_threshold)
    verdict = np.full(len(index), Verdict.ACCEPTED, np.int8)
    verdict[~fitting] = Verdict.POOR_FIT
    verdict[faint | (peaks.peak < config.peak_threshold)] = Verdict.DARK
    verdict[~fitting & ((values >= 1).sum(axis=1) >= SATURATED_SAMPLES)] = Verdict.SATURATED
    verdict[(truth[:, 2] < config.min_range - 1e-6) | (truth[:, 2] > config.max_range + 1e-6)] = (
        Verdict.OUT_OF_RANGE
    )
    return ViewMeasurement(index, points, peaks.peak, angle, width, verdict)


def verdicts(hits: Hits, measured: ViewMeasurement, config: ScannerConfig) -> NDArray[np.int8]:
    """Verdict on every hit of a view, (n,).

    Parameters
    ----------
    hits
    measured
        Of these hits.
    config
    """
    toward = np.array([config.baseline, 0, 0]) - hits.points
    cosine = np.einsum("nd,nd->n", hits.normals, toward) / np.linalg.norm(toward, axis=1)
    out = np.where(cosine > 0, Verdict.SHADOW, Verdict.GRAZING).astype(np.int8)
    out[measured.index] = measured.verdict
    grazing = (out == Verdict.DARK) & (cosine < config.peak_threshold)
    out[grazing] = Verdict.GRAZING
    return out

"""One view measured: intensities over time, fitted peaks, triangulated points, a verdict on every pixel."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scanner_sim.optics import peak, sensor, stripe
from scanner_sim.optics.blur import blurred
from scanner_sim.optics.contributions import Contributions, brightest_rows, contributions
from scanner_sim.optics.hits import Hits
from scanner_sim.optics.noise import SampleNoise
from scanner_sim.optics.rows import Rows
from scanner_sim.optics.triangulation import triangulated
from scanner_sim.optics.verdict import FittedPeaks, judged
from scanner_sim.scanner_config import ScannerConfig

Indirect = Callable[[NDArray[np.int32], stripe.SweptStripes], NDArray[np.float64]]
"""Light by more than one reflection, (m, w), of pixels (m, 2) under the stripes of their rows."""


@dataclass(frozen=True)
class ViewMeasurement:
    """The m lit pixels of a view.

    Attributes
    ----------
    index : (m,) int64
        Into the view's hits: of the rays that light the pixel, the one nearest to the measured point.
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


@dataclass(frozen=True)
class Samples:
    """What the sensor stored of the lit pixels of a view.

    Attributes
    ----------
    lit : Contributions
        Surface points that light each of n rows.
    pixels : (n, 2) int32
    rows : Rows
        Intensities over time, the dark frame subtracted.
    ceiling : (n,) float64
        Intensity at which the sensor saturates.
    """

    lit: Contributions
    pixels: NDArray[np.int32]
    rows: Rows
    ceiling: NDArray[np.float64]


def measure(
    hits: Hits, config: ScannerConfig, seed: int, view: int, indirect: Indirect | None = None
) -> ViewMeasurement:
    """Fit the peak of every lit pixel of a view and triangulate it.

    Parameters
    ----------
    hits
    config
    seed, view
        Identity of the sensor's noise.
    indirect
        Gives light that arrives by more than one reflection, for pixels and their stripes.

    Returns
    -------
    ViewMeasurement
        Of the pixels that the laser reaches.
    """
    stored = samples(hits, config, seed, view, indirect)
    count = len(stored.pixels)
    position, height, width, residual, largest = (np.full(count, np.nan) for _ in range(5))
    accepted, saturated = np.zeros(count, bool), np.zeros(count, np.int64)
    for index in stored.rows.blocks():
        values, ceiling = stored.rows.padded(index), stored.ceiling[index]
        found = peak.fit(values, config.fit, ceiling, config.step)
        position[index], height[index], width[index] = found.position, found.peak, found.width
        residual[index], accepted[index] = found.residual, found.accepted
        largest[index] = values.max(axis=1, initial=0)
        saturated[index] = (values >= ceiling[:, None] - 1e-9).sum(axis=1)
    angle = config.sweep[0] + (stored.rows.first + position + 0.5) * config.step
    points = triangulated(stored.pixels, angle, config)
    point = _nearest_points(stored.lit, hits, points)
    hit = stored.lit.hit[point]
    width *= config.step
    widest = _widest(stored.lit, point, hits, config)
    peaks = FittedPeaks(height, width, residual, accepted, widest, largest, saturated)
    verdict = judged(peaks, points, hits.points[hit], hits.face_ids[hit], config)
    return ViewMeasurement(hit, points, height, angle, width, verdict)


def samples(
    hits: Hits, config: ScannerConfig, seed: int, view: int, indirect: Indirect | None = None
) -> Samples:
    """Intensities over time of the lit pixels of a view; parameters as for `measure`."""
    lit = contributions(hits, config)
    swept = stripe.swept_stripes(lit.laser, config, config.wedge / 2 if indirect else 0.0)
    rows = [lit.gather(swept, lit.amplitude)]
    if config.noise > 0:  # the stripe's own radiance bounds the reference's speckle
        rows.append(lit.gather(swept, lit.share))
    if config.footprint > 1 or config.translucency > 0:
        kept = brightest_rows(lit, rows[0].largest(), hits, config)
        lit, rows = lit.select(kept), [each.select(np.flatnonzero(kept)) for each in rows]
    pixels = hits.pixels[lit.hit[np.searchsorted(lit.row, np.arange(lit.rows))]]
    if config.smoothing > 0 and config.smoothing_stage == "light":
        rows = [blurred(pixels, each, config) for each in rows]
        brightest = rows[0].brightest_runs()
        rows = [each.cut(*brightest) for each in rows]
    light, cast = rows[0], rows[-1]
    if indirect is not None:
        light = Rows(light.first, light.stop, light.values + indirect(pixels, swept).ravel())
    stored, ceiling = _stored(pixels, light, cast, lit.total(lit.ambient), config, seed, view)
    if config.smoothing > 0 and config.smoothing_stage == "image":
        stored = blurred(pixels, stored, config)
    return Samples(lit, pixels, stored, ceiling)


def _stored(
    pixels: NDArray[np.int32],
    light: Rows,
    cast: Rows,
    ambient: NDArray[np.float64],
    config: ScannerConfig,
    seed: int,
    view: int,
) -> tuple[Rows, NDArray[np.float64]]:
    """Rows as the sensor stores them, and the intensity at which each saturates, (n,)."""
    values, ceiling = np.empty_like(light.values), np.empty(len(pixels))
    start, length = light.start, light.stop - light.first
    for index in light.blocks():
        width = int(length[index].max())
        noise = SampleNoise(seed, view, pixels[index], light.first[index], width)
        shown, ceiling[index] = sensor.expose(
            light.padded(index), cast.padded(index), ambient[index], config, noise
        )
        if shown.size == len(values):  # all rows, of one length
            values[:] = shown.ravel()
            continue
        inside = np.arange(width) < length[index][:, None]
        values[(start[index][:, None] + np.arange(width))[inside]] = shown[inside]
    return Rows(light.first, light.stop, values), ceiling


def _nearest_points(lit: Contributions, hits: Hits, points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Of the surface points of each row, the one nearest to the measured point, (n,)."""
    if lit.single:
        return np.arange(lit.rows)
    gap = np.linalg.norm(np.nan_to_num(points)[lit.row] - hits.points[lit.hit], axis=1)
    order = np.lexsort((gap, lit.row))
    return order[np.searchsorted(lit.row, np.arange(lit.rows))]


def _widest(
    lit: Contributions, point: NDArray[np.int64], hits: Hits, config: ScannerConfig
) -> NDArray[np.float64]:
    """Largest accepted width of the peak of each row, radians, (n,)."""
    if config.fit == "reference":
        return np.full(len(point), config.std_threshold * config.wedge / 2)
    laser = stripe.LaserCoordinates(
        lit.laser.angle[point], lit.laser.axis_distance[point], lit.laser.distance[point]
    )
    spread = blur_width(hits.points[lit.hit[point]], hits.normals[lit.hit[point]], config)
    return config.std_threshold * np.hypot(stripe.cast_width(laser, config), spread)


def blur_width(
    points: NDArray[np.float64], normals: NDArray[np.float64], config: ScannerConfig
) -> NDArray[np.float64]:
    """Width that blur over pixels alone gives the peak over time, radians, (n,).

    A surface point moves by dp where its pixel moves by one, and the sheet angle that meets it by
    ``dphi = (z dx - (x - b) dz) / rho^2``; a blur of standard deviation sigma pixels then has the width
    ``s = sqrt 2 sigma |grad phi|``.

    Parameters
    ----------
    points, normals : (n, 3)
        In camera coordinates, mm.
    config
    """
    if config.smoothing == 0:
        return np.zeros(len(points))
    x, z = points[:, 0] - config.baseline, points[:, 2]
    rays = points / z[:, None]
    facing = np.einsum("nd,nd->n", normals, rays)
    facing = np.minimum(
        facing, -0.1 * np.linalg.norm(rays, axis=1)
    )  # silhouettes: no steeper than 84 degrees
    square = np.zeros(len(points))
    for axis in (0, 1):
        shift = np.eye(3)[axis] / config.focal
        moved = z[:, None] * (shift - rays * (normals[:, axis] / config.focal / facing)[:, None])
        square += ((z * moved[:, 0] - x * moved[:, 2]) / (x**2 + z**2)) ** 2
    return np.sqrt(2 * square) * config.smoothing

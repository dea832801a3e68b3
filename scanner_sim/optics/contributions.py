"""Which surface points light which pixel: one, all of a pixel's footprint, or those below the surface."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scanner_sim.optics import stripe
from scanner_sim.optics.hits import Hits
from scanner_sim.optics.rows import Rows
from scanner_sim.optics.translucency import entry_points
from scanner_sim.optics.verdict import cosines
from scanner_sim.scanner_config import ScannerConfig


@dataclass(frozen=True)
class Contributions:
    """Lit surface points in the order of the rows of samples that they belong to.

    Attributes
    ----------
    row : (k,) int64
        Non-decreasing.
    hit : (k,) int64
        Camera ray of each.
    laser : LaserCoordinates
        Of the k places where the laser enters.
    share : (k,) float64
        Part of the pixel's area (and, below the surface, of its light) that a point stands for.
    amplitude : (k,) float64
        Share times what the surface returns of the laser's light.
    ambient : (k,) float64
        Share times what it returns of the ambient light.
    """

    row: NDArray[np.int64]
    hit: NDArray[np.int64]
    laser: stripe.LaserCoordinates
    share: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    ambient: NDArray[np.float64]

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self.row[-1]) + 1 if len(self.row) else 0

    @property
    def single(self) -> bool:
        """Whether every row has one point."""
        return self.rows == len(self.row)

    def select(self, kept: NDArray[np.bool_]) -> "Contributions":
        """The points of some of the rows, (n,) truth values, whose numbers close up."""
        mask = kept[self.row]
        row = (np.cumsum(kept) - 1)[self.row[mask]]
        laser = self.laser
        taken = stripe.LaserCoordinates(laser.angle[mask], laser.axis_distance[mask], laser.distance[mask])
        return Contributions(
            row, self.hit[mask], taken, self.share[mask], self.amplitude[mask], self.ambient[mask]
        )

    def gather(self, swept: stripe.SweptStripes, weights: NDArray[np.float64]) -> Rows:
        """Rows of the sums over their points of weighted stripes."""
        if self.single:
            return Rows.uniform(stripe.SweptStripes(swept.first, swept.values * weights[:, None]))
        return Rows.gathered(self.row, self.rows, swept, weights)

    def total(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sum over the points of each row, (n,)."""
        return np.bincount(self.row, values, minlength=self.rows).astype(np.float64)


def contributions(hits: Hits, config: ScannerConfig) -> Contributions:
    """Lit surface points of a view, by pixel and, where a pixel sees several peaks, by peak.

    Parameters
    ----------
    hits
        Camera rays of a view, `ScannerConfig.footprint` squared to a pixel at most.
    config

    Returns
    -------
    Contributions
        Points whose stripes overlap, directly or through others of their pixel, share a row.
    """
    hit = np.flatnonzero(hits.radiance > 0)
    points, share = hits.points[hit], np.full(len(hit), config.footprint**-2.0)
    if config.translucency > 0:
        places, weights = entry_points(points, hits.normals[hit], config.baseline, config)
        share = (share[:, None] * weights).ravel()
        hit = np.repeat(hit, len(weights))
        points = places.reshape(-1, 3)
    laser = stripe.laser_coordinates(points, config.baseline)
    amplitude = share * hits.radiance[hit] * stripe.falloff(laser, config)
    cosine = np.maximum(cosines(hits, config.baseline)[hit], 1e-3)
    ambient = share * hits.radiance[hit] / cosine * config.ambient
    if config.footprint == 1 and config.translucency == 0:
        return Contributions(np.arange(len(hit)), hit, laser, share, amplitude, ambient)
    order, row = _peaks_of_pixels(hits.pixels[hit], laser, config)
    sorted_laser = stripe.LaserCoordinates(
        laser.angle[order], laser.axis_distance[order], laser.distance[order]
    )
    return Contributions(row, hit[order], sorted_laser, share[order], amplitude[order], ambient[order])


def _peaks_of_pixels(
    pixels: NDArray[np.int32], laser: stripe.LaserCoordinates, config: ScannerConfig
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Order of the points by pixel and sheet angle, and the row of each in that order.

    A row ends where the next point of the pixel is lit only after the stripe has left all before it.
    """
    number = pixels[:, 1].astype(np.int64) * config.resolution[0] + pixels[:, 0]
    order = np.lexsort((laser.angle, number))
    half = stripe.half_angle(laser, config)[order]
    angle, number = laser.angle[order], number[order]
    reach = np.maximum.accumulate(angle + half + number * 10.0) - number * 10.0
    apart = (angle[1:] - half[1:] > reach[:-1] + config.step) | (number[1:] != number[:-1])
    return order, np.concatenate([[0], np.cumsum(apart)]) if len(order) else np.empty(0, np.int64)


def brightest_rows(
    points: Contributions, largest: NDArray[np.float64], hits: Hits, config: ScannerConfig
) -> NDArray[np.bool_]:
    """The row of each pixel whose largest sample is the largest, (n,) truth values.

    Parameters
    ----------
    points
        Of n rows.
    largest : (n,)
        Largest sample of each row.
    hits
    config
    """
    if points.rows == 0:
        return np.empty(0, bool)
    leader = np.searchsorted(points.row, np.arange(points.rows))
    pixels = hits.pixels[points.hit[leader]].astype(np.int64)
    number = pixels[:, 1] * config.resolution[0] + pixels[:, 0]
    order = np.lexsort((-largest, number))
    kept = np.zeros(points.rows, bool)
    kept[order[np.concatenate([[True], np.diff(number[order]) > 0])]] = True
    return kept

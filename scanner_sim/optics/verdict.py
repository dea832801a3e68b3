"""What became of each pixel of a view, and why."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from scanner_sim.optics.hits import Hits
from scanner_sim.scanner_config import ScannerConfig


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


SATURATED_SAMPLES = 3
"""A pixel whose peak is rejected counts as saturated if this many of its samples are."""


@dataclass(frozen=True)
class FittedPeaks:
    """Peaks of n rows of samples, and what they are judged by.

    Attributes
    ----------
    peak, width, residual : (n,) float64
        NaN without a peak; the width in the unit of `widest`.
    accepted : (n,) bool
        By the detector itself.
    widest : (n,) float64
        Largest width that is accepted.
    largest : (n,) float64
        Largest sample of each row.
    saturated : (n,) int64
        Number of its saturated samples.
    """

    peak: NDArray[np.float64]
    width: NDArray[np.float64]
    residual: NDArray[np.float64]
    accepted: NDArray[np.bool_]
    widest: NDArray[np.float64]
    largest: NDArray[np.float64]
    saturated: NDArray[np.int64]


def judged(
    peaks: FittedPeaks,
    points: NDArray[np.float64],
    truth: NDArray[np.float64],
    face_ids: NDArray[np.integer],
    config: ScannerConfig,
) -> NDArray[np.int8]:
    """What becomes of each peak.

    Parameters
    ----------
    peaks
    points : (n, 3)
        Triangulated, in camera coordinates, mm; not finite without a peak.
    truth : (n, 3)
        The surface points that they measure.
    face_ids : (n,)
        Of those; negative on the background.
    config

    Returns
    -------
    (n,) int8
        Of `Verdict`.
    """
    fitting = peaks.accepted & (points[:, 2] > 0) & (peaks.width <= peaks.widest)
    if config.fit != "reference":
        fitting &= peaks.residual <= config.residual_threshold
    if config.depth_threshold is not None:
        fitting &= np.linalg.norm(points - truth, axis=1) <= config.depth_threshold
    faint = np.isnan(peaks.peak) & (peaks.largest < config.peak_threshold)
    distance = np.linalg.norm(truth, axis=1)
    verdict = np.full(len(points), Verdict.ACCEPTED, np.int8)
    verdict[~fitting] = Verdict.POOR_FIT
    verdict[faint | (peaks.peak < config.peak_threshold)] = Verdict.DARK
    verdict[~fitting & (peaks.saturated >= SATURATED_SAMPLES)] = Verdict.SATURATED
    outside = (distance < config.min_range - 1e-6) | (distance > config.max_range + 1e-6)
    verdict[outside] = Verdict.OUT_OF_RANGE
    verdict[face_ids < 0] = Verdict.MISS
    return verdict


def cosines(hits: Hits, baseline: float) -> NDArray[np.float64]:
    """Cosine between shading normal and direction to the laser of each hit, (n,)."""
    toward = np.array([baseline, 0, 0]) - hits.points
    return np.einsum("nd,nd->n", hits.normals, toward) / np.linalg.norm(toward, axis=1)


def verdicts(
    hits: Hits, index: NDArray[np.integer], verdict: NDArray[np.integer], config: ScannerConfig
) -> NDArray[np.int8]:
    """Verdict on every hit of a view; the hits of one pixel share that of the pixel.

    Parameters
    ----------
    hits
        n camera rays.
    index, verdict : (m,)
        One hit of every pixel that was measured, and what became of it.
    config

    Returns
    -------
    (n,) int8
    """
    cosine = cosines(hits, config.baseline)
    out = np.where(cosine > 0, Verdict.SHADOW, Verdict.GRAZING).astype(np.int8)
    out[index] = verdict
    out[(out == Verdict.DARK) & (cosine < config.peak_threshold)] = Verdict.GRAZING
    if config.footprint > 1 and len(out):
        measured = np.zeros(len(out), bool)
        measured[index] = True
        stride = int(hits.pixels[:, 0].max(initial=0)) + 1  # a profiler counts frames, not columns
        number = hits.pixels[:, 1].astype(np.int64) * stride + hits.pixels[:, 0]
        order = np.lexsort((~measured, number))  # of each pixel, the measured ray first
        leader = np.concatenate([[True], np.diff(number[order]) > 0])
        out[order] = out[order][np.flatnonzero(leader)][np.cumsum(leader) - 1]
    out[hits.face_ids < 0] = Verdict.MISS
    return out

"""Peaks over time: where, how bright and how wide each pixel saw the laser."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import ranges, run_tasks
from datasets_gen.records import InputError
from scanner_sim.optics.detectors import (
    centre_of_mass,
    fir,
    gaussian,
    least_squares,
    parabola,
    reference,
    steger,
)
from scanner_sim.optics.detectors.lit_samples import FLOOR

__all__ = ["DETECTORS", "FLOOR", "Peaks", "fit"]

ROWS_PER_TASK = 4096

DETECTORS: dict[str, Callable[..., None]] = {
    "reference": reference.detect,
    "least_squares": least_squares.detect,
    "gaussian": gaussian.detect,
    "centre_of_mass": centre_of_mass.detect,
    "parabola": parabola.detect,
    "fir": fir.detect,
    "steger": steger.detect,
}
"""What finds the peak of each row, by the name of `ScannerConfig.fit`; each is compiled when first used."""


@dataclass(frozen=True)
class Peaks:
    """Gaussians ``peak * exp(-(x - position)^2 / width^2)``, x counting samples.

    Attributes
    ----------
    peak, position, width : (n,) float64
        NaN where fewer than 3 samples are lit or no peak exists.
    residual : (n,) float64
        Root mean square residual over the lit samples, relative to the peak.
    accepted : (n,) bool
        Whether the detector itself accepts: the reference only if half the sum of squared residuals is at
        most 0.1, the others every peak.
    """

    peak: NDArray[np.float64]
    position: NDArray[np.float64]
    width: NDArray[np.float64]
    residual: NDArray[np.float64]
    accepted: NDArray[np.bool_]


def fit(
    values: NDArray[np.float64],
    method: str = "reference",
    ceiling: NDArray[np.float64] | None = None,
    step: float = 1.0,
) -> Peaks:
    """Find the peak of each row of samples.

    Parameters
    ----------
    values : (n, w)
        Intensities; those up to `FLOOR` are ignored.
    method
        One of `DETECTORS`.
    ceiling : (n,) or None
        Intensity at which samples of a row are saturated; no peak is higher, but for the reference's, which
        does not know. None: no end of the range is known.
    step
        Angle between samples, radians; decides how far the reference refines.

    Returns
    -------
    Peaks
        The same whatever the number of threads.

    Raises
    ------
    InputError
        If there is no such method.
    """
    if method not in DETECTORS:
        raise InputError(f"unknown peak detector {method!r}; known ones are {', '.join(DETECTORS)}")
    rows = np.ascontiguousarray(values, dtype=np.float64)
    top = np.ascontiguousarray(np.full(len(rows), np.inf) if ceiling is None else ceiling, dtype=np.float64)
    out = np.empty((len(rows), 5))
    detect = DETECTORS[method]
    run_tasks(
        lambda a, b: detect(rows[a:b], top[a:b], float(step), out[a:b]), ranges(len(rows), ROWS_PER_TASK)
    )
    peak, position, width, residual, accepted = (np.ascontiguousarray(column) for column in out.T)
    return Peaks(peak, position, width, residual, accepted == 1)

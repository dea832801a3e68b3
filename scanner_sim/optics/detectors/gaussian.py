"""A Gaussian in closed form: the parabola through the logarithms, weighted by the squared intensities.

References
----------
[Guo11] Guo, "A simple algorithm for fitting a Gaussian function", IEEE Signal Processing Magazine 28(5),
2011.
"""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled
from scanner_sim.optics.detectors.lit_samples import FLOOR, LEAST, record, saturated


@compiled()
def counts(value: float, ceiling: float) -> bool:
    """Whether a sample is lit and not saturated."""
    return value > FLOOR and not saturated(value, ceiling)


@compiled()
def log_parabola(row: NDArray[np.float64], ceiling: float) -> tuple[float, float, float]:
    """Peak, position, width by weighted least squares of ln I on a parabola; NaN where it has no maximum."""
    count = 0
    mass = 0.0
    mean = 0.0
    for x in range(len(row)):
        if counts(row[x], ceiling):
            count += 1
            mass += row[x] * row[x]
            mean += row[x] * row[x] * x
    if count < LEAST:
        return np.nan, np.nan, np.nan
    mean /= mass
    s1 = s2 = s3 = s4 = t0 = t1 = t2 = 0.0
    for x in range(len(row)):
        if counts(row[x], ceiling):
            w = row[x] * row[x] / mass
            d = x - mean
            y = np.log(row[x])
            s1 += w * d
            s2 += w * d * d
            s3 += w * d**3
            s4 += w * d**4
            t0 += w * y
            t1 += w * d * y
            t2 += w * d * d * y
    # normal equations of y = a + b d + c d^2 with weights summing to 1, by elimination of a
    m11, m12, m22 = s2 - s1 * s1, s3 - s1 * s2, s4 - s2 * s2
    r1, r2 = t1 - s1 * t0, t2 - s2 * t0
    det = m11 * m22 - m12 * m12
    if det <= 1e-14 * m11 * m22:
        return np.nan, np.nan, np.nan
    b = (r1 * m22 - r2 * m12) / det
    c = (r2 * m11 - r1 * m12) / det
    a = t0 - b * s1 - c * s2
    if c >= 0:
        return np.nan, np.nan, np.nan
    return np.exp(a - b * b / (4 * c)), mean - b / (2 * c), np.sqrt(-1 / c)


@compiled()
def detect(
    values: NDArray[np.float64], ceiling: NDArray[np.float64], step: float, out: NDArray[np.float64]
) -> None:
    """Detect the peak of every row; at least 3 of its samples must not be saturated."""
    for i in range(len(values)):
        peak, position, width = log_parabola(values[i], ceiling[i])
        record(values[i], ceiling[i], peak, position, width, out[i])

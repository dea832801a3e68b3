r"""The maximum of the smoothed signal's Taylor polynomial, from its first two derivatives at a sample.

With r the signal smoothed by a Gaussian, the peak is ``t = -r' / r''`` from the sample nearest to it. Samples
are areas: the signal is constant over each, so kernels are integrated over a sample.

References
----------
[Steger98] Steger, "An unbiased detector of curvilinear structures", IEEE Transactions on Pattern Analysis and
Machine Intelligence 20(2), 1998, Section 2.
"""

import math

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled
from scanner_sim.optics.detectors.lit_samples import LEAST, bright, describe, largest, lit, sample

DEVIATIONS = math.sqrt(8 * math.log(2))
"""Full width at half maximum of a Gaussian, in standard deviations."""


@compiled()
def smoothing(row: NDArray[np.float64], top: int) -> float:
    """Standard deviation of the smoothing: the peak's own.

    A bar of half width w needs at least ``w / sqrt 3`` [Steger98], which is the bar's own deviation.
    """
    return bright(row, row[top]) / DEVIATIONS


@compiled()
def offset(row: NDArray[np.float64], x: int, sigma: float) -> float:
    """``-r' / r''`` at a sample, up to the scale that both have in common; NaN where r is not concave."""
    slope = bend = 0.0
    for k in range(len(row)):
        before, after = x - k - 0.5, x - k + 0.5
        low, high = np.exp(-0.5 * (before / sigma) ** 2), np.exp(-0.5 * (after / sigma) ** 2)
        slope += sample(row, k) * (high - low)
        bend += sample(row, k) * (before * low - after * high) / sigma**2
    return -slope / bend if bend < 0 else np.nan


@compiled()
def located(row: NDArray[np.float64]) -> float:
    """Position of the peak of one row: from the largest sample towards the one nearest to its maximum.

    Where two neighbours both place it beyond their middle, it is where their offsets interpolate to 0.
    """
    if lit(row) < LEAST:
        return np.nan
    first, last = largest(row)
    x = (first + last) // 2
    sigma = smoothing(row, first)
    t = offset(row, x, sigma)
    while abs(t) > 0.5:
        side = 1 if t > 0 else -1
        other = offset(row, x + side, sigma)
        if np.isnan(other) or (other * side > 0 and abs(other) > abs(t)):
            return np.nan
        if other * side < -0.5:
            return x + side * abs(t) / (abs(t) + abs(other))
        x, t = x + side, other
    return x + t


@compiled()
def detect(
    values: NDArray[np.float64], ceiling: NDArray[np.float64], step: float, out: NDArray[np.float64]
) -> None:
    """Detect the peak of every row."""
    for i in range(len(values)):
        describe(values[i], ceiling[i], located(values[i]), out[i])

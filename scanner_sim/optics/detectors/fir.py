"""The zero crossing of the signal's derivative, by a finite impulse response filter of order 4 or 8.

References
----------
[BR86] Blais, Rioux, "Real-time numerical peak detector", Signal Processing 11(2), 1986.
"""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled
from scanner_sim.optics.detectors.lit_samples import LEAST, bright, describe, largest, lit, sample

NARROW = 4
"""Peaks of at most this full width at half maximum, in samples, take order 4; wider ones order 8."""


@compiled()
def derivative(row: NDArray[np.float64], x: int, order: int) -> float:
    """``f(x-1) + ... + f(x-order/2) - f(x+1) - ... - f(x+order/2)``: negative on the rising side [BR86]."""
    total = 0.0
    for k in range(1, order // 2 + 1):
        total += sample(row, x - k) - sample(row, x + k)
    return total


@compiled()
def crossing(row: NDArray[np.float64], top: int, order: int) -> float:
    """Zero crossing of the derivative nearest to the largest sample, by linear interpolation.

    There is one: beyond the first lit sample the derivative is negative, beyond the last one positive.
    """
    x = top
    while derivative(row, x, order) > 0:
        x -= 1
    while derivative(row, x + 1, order) <= 0:
        x += 1
    before, after = derivative(row, x, order), derivative(row, x + 1, order)
    return x + before / (before - after)


@compiled()
def located(row: NDArray[np.float64]) -> float:
    """Position of the peak of one row."""
    if lit(row) < LEAST:
        return np.nan
    first, last = largest(row)
    order = 4 if bright(row, row[first]) <= NARROW else 8
    return crossing(row, (first + last) // 2, order)


@compiled()
def detect(
    values: NDArray[np.float64], ceiling: NDArray[np.float64], step: float, out: NDArray[np.float64]
) -> None:
    """Detect the peak of every row."""
    for i in range(len(values)):
        describe(values[i], ceiling[i], located(values[i]), out[i])

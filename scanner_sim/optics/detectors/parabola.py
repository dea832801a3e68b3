"""The vertex of the parabola through the largest sample and its neighbours.

References
----------
[FN96] Fisher, Naidu, "A comparison of algorithms for subpixel peak detection", in: Image Technology, Springer
1996.
"""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled
from scanner_sim.optics.detectors.lit_samples import LEAST, describe, largest, lit, sample


@compiled()
def vertex(left: float, here: float, right: float) -> float:
    """Distance of the vertex from the middle one of three samples, of which it is the largest [FN96]."""
    return 0.5 * (left - right) / (left - 2 * here + right)


@compiled()
def located(row: NDArray[np.float64]) -> float:
    """Vertex of the parabola; the middle of a plateau of the largest intensity."""
    if lit(row) < LEAST:
        return np.nan
    first, last = largest(row)
    if last > first:
        return 0.5 * (first + last)
    return first + vertex(sample(row, first - 1), row[first], sample(row, first + 1))


@compiled()
def detect(
    values: NDArray[np.float64], ceiling: NDArray[np.float64], step: float, out: NDArray[np.float64]
) -> None:
    """Detect the peak of every row."""
    for i in range(len(values)):
        describe(values[i], ceiling[i], located(values[i]), out[i])

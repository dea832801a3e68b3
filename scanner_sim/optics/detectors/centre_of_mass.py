"""The centre of mass of the samples about the largest one.

References
----------
[FN96] Fisher, Naidu, "A comparison of algorithms for subpixel peak detection", in: Image Technology, Springer
1996.
"""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled
from scanner_sim.optics.detectors.lit_samples import LEAST, describe, largest, lit, reach, sample


@compiled()
def centre_of_mass(row: NDArray[np.float64], first: int, last: int) -> float:
    """Intensity-weighted mean of the sample numbers `first` to `last` [FN96]."""
    mass = moment = 0.0
    for x in range(first, last + 1):
        mass += sample(row, x)
        moment += sample(row, x) * x
    return moment / mass


@compiled()
def located(row: NDArray[np.float64]) -> float:
    """Centre of mass of as many samples on both sides of the largest as belong to its peak."""
    if lit(row) < LEAST:
        return np.nan
    first, last = largest(row)
    size = reach(row, row[first])
    return centre_of_mass(row, first - size, last + size)


@compiled()
def detect(
    values: NDArray[np.float64], ceiling: NDArray[np.float64], step: float, out: NDArray[np.float64]
) -> None:
    """Detect the peak of every row."""
    for i in range(len(values)):
        describe(values[i], ceiling[i], located(values[i]), out[i])

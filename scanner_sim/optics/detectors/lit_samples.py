"""What peak detectors share: which samples of a row count, and what is said of a peak that was located."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled

FLOOR = 1e-6
"""Intensities up to this are no measurement."""

LEAST = 3
"""Samples that a peak needs: it has three unknowns."""

ROUNDING = 1e-9
"""A sample this little below the ceiling is saturated."""

WINDOW = 1.5
"""Samples that describe a peak: as far from the largest as this times the full width at half maximum."""


@compiled()
def saturated(value: float, ceiling: float) -> bool:
    """Whether a sample is at the end of the sensor's range."""
    return value >= ceiling - ROUNDING


@compiled()
def sample(row: NDArray[np.float64], x: int) -> float:
    """Intensity of a sample; 0 where it does not count or lies outside the row."""
    if x < 0 or x >= len(row) or row[x] <= FLOOR:
        return 0.0
    return row[x]


@compiled()
def lit(row: NDArray[np.float64]) -> int:
    """Number of samples that count."""
    count = 0
    for x in range(len(row)):
        if row[x] > FLOOR:
            count += 1
    return count


@compiled()
def largest(row: NDArray[np.float64]) -> tuple[int, int]:
    """First and last sample of the plateau of the largest intensity; it is the first such plateau."""
    first = 0
    for x in range(1, len(row)):
        if row[x] > row[first]:
            first = x
    last = first
    while last + 1 < len(row) and row[last + 1] == row[first]:
        last += 1
    return first, last


@compiled()
def bright(row: NDArray[np.float64], top: float) -> int:
    """Samples of at least half of an intensity: the full width at half maximum, in whole samples."""
    count = 0
    for x in range(len(row)):
        if row[x] >= 0.5 * top:
            count += 1
    return count


@compiled()
def reach(row: NDArray[np.float64], top: float) -> int:
    """Samples on either side of the largest one, of intensity `top`, that belong to its peak."""
    return int(np.ceil(WINDOW * bright(row, top)))


@compiled()
def squares(row: NDArray[np.float64], ceiling: float, peak: float, position: float, width: float) -> float:
    """Sum of squared residuals of a Gaussian; saturated samples only say that it is not below the ceiling."""
    total = 0.0
    for x in range(len(row)):
        if row[x] > FLOOR:
            u = (x - position) / width
            r = row[x] - peak * np.exp(-u * u)
            if r > 0 or not saturated(row[x], ceiling):
                total += r * r
    return total


@compiled()
def record(
    row: NDArray[np.float64],
    ceiling: float,
    peak: float,
    position: float,
    width: float,
    out: NDArray[np.float64],
) -> None:
    """Write a Gaussian, the peak no higher than the ceiling, and its relative residual; NaN without one."""
    out[:4] = np.nan
    out[4] = 0.0
    if not np.isnan(peak):
        total = squares(row, ceiling, peak, position, width)
        out[0] = min(peak, ceiling)
        out[1] = position
        out[2] = width
        out[3] = np.sqrt(total / lit(row)) / out[0]
        out[4] = 1.0


@compiled()
def interpolated(row: NDArray[np.float64], position: float) -> float:
    """Intensity at a position, on the parabola through the three samples nearest to it."""
    x = int(np.round(position))
    d = position - x
    left, here, right = sample(row, x - 1), sample(row, x), sample(row, x + 1)
    return here + 0.5 * d * (right - left) + 0.5 * d * d * (left - 2 * here + right)


@compiled()
def spread(row: NDArray[np.float64], position: float) -> float:
    """Width of the Gaussian that has the second moment of the samples about a position."""
    first, last = largest(row)
    size = reach(row, row[first])
    mass = moment = 0.0
    for x in range(first - size, last + size + 1):
        weight = sample(row, x)
        mass += weight
        moment += weight * (x - position) ** 2
    return np.sqrt(2 * moment / mass)


@compiled()
def describe(row: NDArray[np.float64], ceiling: float, position: float, out: NDArray[np.float64]) -> None:
    """Write what a detector of positions implies: intensity there, width by second moment, residual."""
    peak = width = np.nan
    if not np.isnan(position):
        peak = min(interpolated(row, position), ceiling)
        width = spread(row, position)
    if not (peak > FLOOR and width > 0):
        peak = np.nan
    record(row, ceiling, peak, position, width, out)

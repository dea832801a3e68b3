"""A Gaussian by least squares on the intensities themselves; saturated samples are censored.

Of a saturated sample only a lower bound is known, so it counts only where the Gaussian lies below it (as in
the Tobit model [Tobin58], with the normal tail replaced by its quadratic).

References
----------
[Tobin58] Tobin, "Estimation of relationships for limited dependent variables", Econometrica 26(1), 1958.
[Marquardt63] Marquardt, "An algorithm for least-squares estimation of nonlinear parameters", Journal of the
Society for Industrial and Applied Mathematics 11(2), 1963: damping in proportion to the diagonal.
"""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled
from scanner_sim.optics.detectors.gaussian import counts, log_parabola
from scanner_sim.optics.detectors.lit_samples import FLOOR, LEAST, record, saturated, squares

ITERATIONS = 30

Triple = tuple[float, float, float]


@compiled()
def unsaturated(row: NDArray[np.float64], ceiling: float) -> int:
    """Number of samples that are lit and not saturated."""
    count = 0
    for x in range(len(row)):
        if counts(row[x], ceiling):
            count += 1
    return count


@compiled()
def moments(row: NDArray[np.float64]) -> Triple:
    """Largest sample, centre of mass, and the width of a Gaussian with the same second moment."""
    peak = mass = moment = spread = 0.0
    for x in range(len(row)):
        if row[x] > FLOOR:
            peak = max(peak, row[x])
            mass += row[x]
            moment += row[x] * x
    position = moment / mass
    for x in range(len(row)):
        if row[x] > FLOOR:
            spread += row[x] * (x - position) ** 2
    return peak, position, np.sqrt(2 * spread / mass)


@compiled()
def normal_equations(
    row: NDArray[np.float64], ceiling: float, gaussian: Triple
) -> tuple[Triple, Triple, Triple]:
    """Diagonal of J^T J, the entries 01, 02 and 12 beside it, and J^T r; r is observation minus model."""
    peak, position, width = gaussian
    h00 = h11 = h22 = h01 = h02 = h12 = g0 = g1 = g2 = 0.0
    for x in range(len(row)):
        if row[x] > FLOOR:
            u = (x - position) / width
            e = np.exp(-u * u)
            r = row[x] - peak * e
            if r > 0 or not saturated(row[x], ceiling):
                j1, j2 = 2 * peak * e * u / width, 2 * peak * e * u * u / width
                h00, h11, h22 = h00 + e * e, h11 + j1 * j1, h22 + j2 * j2
                h01, h02, h12 = h01 + e * j1, h02 + e * j2, h12 + j1 * j2
                g0, g1, g2 = g0 + e * r, g1 + j1 * r, g2 + j2 * r
    return (h00, h11, h22), (h01, h02, h12), (g0, g1, g2)


@compiled()
def damped_step(diagonal: Triple, beside: Triple, gradient: Triple, damping: float) -> Triple:
    """Solve the system with its diagonal enlarged by ``1 + damping`` [Marquardt63], by Cramer's rule."""
    g0, g1, g2 = gradient
    a, b, c = diagonal[0] * (1 + damping), beside[0], beside[1]
    d, e, f = diagonal[1] * (1 + damping), beside[2], diagonal[2] * (1 + damping)
    c0, c1, c2 = d * f - e * e, c * e - b * f, b * e - c * d
    det = a * c0 + b * c1 + c * c2
    if det == 0:
        return 0.0, 0.0, 0.0
    return (
        (g0 * c0 + g1 * c1 + g2 * c2) / det,
        (g0 * c1 + g1 * (a * f - c * c) + g2 * (b * c - a * e)) / det,
        (g0 * c2 + g1 * (b * c - a * e) + g2 * (a * d - b * b)) / det,
    )


@compiled()
def refined(row: NDArray[np.float64], ceiling: float, gaussian: Triple) -> Triple:
    """Levenberg-Marquardt on the intensities."""
    peak, position, width = gaussian
    cost = squares(row, ceiling, peak, position, width)
    damping = 1e-3
    for _ in range(ITERATIONS):
        diagonal, beside, gradient = normal_equations(row, ceiling, (peak, position, width))
        step = damped_step(diagonal, beside, gradient, damping)
        p, m, s = peak + step[0], position + step[1], width + step[2]
        trial = squares(row, ceiling, p, m, s) if p > 0 and s > 0 else np.inf
        if trial <= cost:
            small = abs(step[1]) < 1e-5 * width and abs(step[0]) < 1e-5 * peak
            peak, position, width = p, m, s
            cost = trial
            damping *= 0.1
            if small:
                break
        else:
            damping *= 10
            if damping > 1e8:
                break
    return peak, position, width


@compiled()
def plausible(row: NDArray[np.float64], gaussian: Triple) -> bool:
    """Whether there is a peak, within a sample of the lit ones, that is narrower than they reach."""
    first, last = 0, len(row) - 1
    while row[first] <= FLOOR:
        first += 1
    while row[last] <= FLOOR:
        last -= 1
    peak, position, width = gaussian
    return peak > 0 and first - 1 <= position <= last + 1 and width < last - first + 1


@compiled()
def fitted(row: NDArray[np.float64], ceiling: float) -> Triple:
    """Gaussian of one row, from the parabola through its logarithms or, if that fails, from its moments."""
    none = (np.nan, np.nan, np.nan)
    if unsaturated(row, ceiling) < LEAST:
        return none
    begin = log_parabola(row, ceiling)
    if not plausible(row, begin):
        begin = moments(row)
    end = refined(row, ceiling, begin)
    return end if plausible(row, end) else none


@compiled()
def detect(
    values: NDArray[np.float64], ceiling: NDArray[np.float64], step: float, out: NDArray[np.float64]
) -> None:
    """Detect the peak of every row; at least 3 of its samples must not be saturated."""
    for i in range(len(values)):
        peak, position, width = fitted(values[i], ceiling[i])
        record(values[i], ceiling[i], peak, position, width, out[i])

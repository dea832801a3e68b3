r"""The detector of [BLN*11]: the centre of mass and the largest sample, refined only where they fit badly.

The start is the intensity-weighted mean of the angles, the largest sample, and the root mean square distance
of the samples from that mean, not weighted. Levenberg-Marquardt looks at the mean squared residual before
each round and stops below `GOOD`; most pixels therefore keep the start, and their peak is a sample.

References
----------
[BLN*11] Berger, Levine, Nonato, Taubin, Silva, "An end-to-end framework for evaluating surface
reconstruction", SCI Technical Report UUSCI-2011-001.
[MNT04] Madsen, Nielsen, Tingleff, "Methods for non-linear least squares problems", Technical University of
Denmark, 2004, Algorithm 3.16: the rules for the damping.
"""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled
from scanner_sim.optics.detectors.lit_samples import FLOOR, LEAST

ROUNDS = 50
GOOD = 0.01
"""Mean squared residual below which nothing is refined."""

ACCEPTED = 0.1
"""Largest half sum of squared residuals of an accepted fit."""

DAMPING = 1e-5
"""Of the first round, relative to the largest diagonal entry of the normal equations."""

Gaussian = tuple[float, float, float]
"""Peak, position and width; here both in radians from the first sample of the row."""


@compiled()
def start(row: NDArray[np.float64], step: float) -> tuple[float, float, float, int]:
    """Largest sample, centre of mass, unweighted spread; and the number of samples that count."""
    count = 0
    peak = mass = moment = 0.0
    for i in range(len(row)):
        if row[i] > FLOOR:
            count += 1
            peak = max(peak, row[i])
            mass += row[i]
            moment += row[i] * (i * step)
    position = moment / mass
    spread = 0.0
    for i in range(len(row)):
        if row[i] > FLOOR:
            spread += (i * step - position) ** 2
    return peak, position, np.sqrt(spread / count), count


@compiled()
def energy(row: NDArray[np.float64], step: float, gaussian: Gaussian) -> float:
    """Half the sum of squared residuals, E."""
    peak, position, width = gaussian
    total = 0.0
    for i in range(len(row)):
        if row[i] > FLOOR:
            u = (i * step - position) / width
            r = peak * np.exp(-u * u) - row[i]
            total += r * r
    return 0.5 * total


@compiled()
def normal_equations(
    row: NDArray[np.float64], step: float, gaussian: Gaussian
) -> tuple[Gaussian, Gaussian, Gaussian]:
    """Diagonal of J^T J, the entries 01, 02 and 12 beside it, and J^T r; r is model minus observation."""
    peak, position, width = gaussian
    h00 = h11 = h22 = h01 = h02 = h12 = g0 = g1 = g2 = 0.0
    for i in range(len(row)):
        if row[i] > FLOOR:
            u = (i * step - position) / width
            e = np.exp(-u * u)
            r = peak * e - row[i]
            j1, j2 = 2 * peak * e * u / width, 2 * peak * e * u * u / width
            h00, h11, h22 = h00 + e * e, h11 + j1 * j1, h22 + j2 * j2
            h01, h02, h12 = h01 + e * j1, h02 + e * j2, h12 + j1 * j2
            g0, g1, g2 = g0 + e * r, g1 + j1 * r, g2 + j2 * r
    return (h00, h11, h22), (h01, h02, h12), (g0, g1, g2)


@compiled()
def damped_step(diagonal: Gaussian, beside: Gaussian, gradient: Gaussian, damping: float) -> Gaussian:
    """Solve ``(J^T J + damping I) delta = -J^T r`` by Cholesky's decomposition."""
    l00 = np.sqrt(diagonal[0] + damping)
    l10, l20 = beside[0] / l00, beside[1] / l00
    l11 = np.sqrt(diagonal[1] + damping - l10 * l10)
    l21 = (beside[2] - l20 * l10) / l11
    l22 = np.sqrt(diagonal[2] + damping - l20 * l20 - l21 * l21)
    y0 = -gradient[0] / l00
    y1 = (-gradient[1] - l10 * y0) / l11
    y2 = (-gradient[2] - l20 * y0 - l21 * y1) / l22
    d2 = y2 / l22
    d1 = (y1 - l21 * d2) / l11
    return (y0 - l10 * d1 - l20 * d2) / l00, d1, d2


@compiled()
def predicted(delta: Gaussian, gradient: Gaussian, damping: float) -> float:
    """Decrease of E that the linear model promises: ``0.5 delta . (damping delta - J^T r)`` [MNT04, 3.14]."""
    total = 0.0
    for k in range(3):
        total += delta[k] * (damping * delta[k] - gradient[k])
    return 0.5 * total


@compiled()
def refined(row: NDArray[np.float64], step: float, gaussian: Gaussian, count: int) -> tuple[Gaussian, float]:
    """Levenberg-Marquardt; the Gaussian, and E when it was last compared with `GOOD`."""
    now = checked = energy(row, step, gaussian)
    damping, growth = 0.0, 2.0
    for turn in range(ROUNDS):
        checked = now
        if 2 * checked / count < GOOD:
            break
        diagonal, beside, gradient = normal_equations(row, step, gaussian)
        if turn == 0:
            damping = DAMPING * max(diagonal[0], diagonal[1], diagonal[2])
        delta = damped_step(diagonal, beside, gradient, damping)
        trial = (gaussian[0] + delta[0], gaussian[1] + delta[1], gaussian[2] + delta[2])
        then = energy(row, step, trial)
        gain = (now - then) / predicted(delta, gradient, damping)
        if gain > 0:
            gaussian, now = trial, then
            damping *= max(1 / 3, 1 - (2 * gain - 1) ** 3)
            growth = 2.0
        else:
            damping *= growth
            growth *= 2
    return gaussian, checked


@compiled()
def detect(
    values: NDArray[np.float64], ceiling: NDArray[np.float64], step: float, out: NDArray[np.float64]
) -> None:
    """Detect the peak of every row; `step` decides the damping, and so where refinement stops."""
    for i in range(len(values)):
        peak, position, width, count = start(values[i], step)
        if count < LEAST:
            out[i, :4] = np.nan
            out[i, 4] = 0.0
            continue
        gaussian, left = refined(values[i], step, (peak, position, width), count)
        out[i, 0] = gaussian[0]
        out[i, 1] = gaussian[1] / step
        out[i, 2] = abs(gaussian[2]) / step
        out[i, 3] = np.sqrt(2 * left / count) / gaussian[0]
        out[i, 4] = left <= ACCEPTED

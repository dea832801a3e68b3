"""Gaussian peaks over time: where, how bright and how wide each pixel saw the laser."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled, ranges, run_tasks

FLOOR = 1e-6
"""Intensities below this are no measurement."""

ITERATIONS = 30
ROWS_PER_TASK = 4096


@dataclass(frozen=True)
class Peaks:
    """Fits of ``peak * exp(-(x - position)^2 / width^2)``, x counting samples.

    Attributes
    ----------
    peak, position, width : (n,) float64
        NaN where fewer than 3 samples are lit or no peak exists.
    residual : (n,) float64
        Root mean square residual over the samples used, relative to the peak.
    """

    peak: NDArray[np.float64]
    position: NDArray[np.float64]
    width: NDArray[np.float64]
    residual: NDArray[np.float64]


def fit(values: NDArray[np.float64], method: str = "iterative") -> Peaks:
    """Fit a Gaussian to each row of samples.

    Parameters
    ----------
    values : (n, w)
        Intensities; those up to `FLOOR` are ignored.
    method
        ``"closed"``: weighted parabola through the logarithms [Guo 2011], no iteration. ``"iterative"``:
        least squares on the intensities themselves (Levenberg-Marquardt), started from it.

    Returns
    -------
    Peaks
        The same whatever the number of threads.
    """
    out = np.empty((len(values), 4))
    rows = np.ascontiguousarray(values, dtype=np.float64)
    run_tasks(lambda a, b: _fit(rows[a:b], method == "iterative", out[a:b]), ranges(len(rows), ROWS_PER_TASK))
    return Peaks(*(np.ascontiguousarray(out[:, k]) for k in range(4)))


@compiled()
def _closed(row: NDArray[np.float64]) -> tuple[float, float, float, int]:
    """Peak, position, width by weighted least squares of ln I on a parabola; and the sample count."""
    count = 0
    mass = 0.0
    mean = 0.0
    for x in range(len(row)):
        if row[x] > FLOOR:
            count += 1
            mass += row[x] * row[x]
            mean += row[x] * row[x] * x
    if count < 3:
        return np.nan, np.nan, np.nan, count
    mean /= mass
    s1 = s2 = s3 = s4 = t0 = t1 = t2 = 0.0
    for x in range(len(row)):
        if row[x] > FLOOR:
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
        return np.nan, np.nan, np.nan, count
    b = (r1 * m22 - r2 * m12) / det
    c = (r2 * m11 - r1 * m12) / det
    a = t0 - b * s1 - c * s2
    if c >= 0:
        return np.nan, np.nan, np.nan, count
    return np.exp(a - b * b / (4 * c)), mean - b / (2 * c), np.sqrt(-1 / c), count


@compiled()
def _squares(row: NDArray[np.float64], peak: float, position: float, width: float) -> float:
    """Sum of squared residuals over the lit samples."""
    total = 0.0
    for x in range(len(row)):
        if row[x] > FLOOR:
            u = (x - position) / width
            r = row[x] - peak * np.exp(-u * u)
            total += r * r
    return total


@compiled()
def _refine(
    row: NDArray[np.float64], peak: float, position: float, width: float
) -> tuple[float, float, float, float]:
    """Levenberg-Marquardt on the intensities; returns the three unknowns and the sum of squares."""
    cost = _squares(row, peak, position, width)
    damping = 1e-3
    for _ in range(ITERATIONS):
        h = np.zeros((3, 3))
        g = np.zeros(3)
        for x in range(len(row)):
            if row[x] > FLOOR:
                u = (x - position) / width
                e = np.exp(-u * u)
                r = row[x] - peak * e
                j0, j1, j2 = e, 2 * peak * e * u / width, 2 * peak * e * u * u / width
                g[0] += j0 * r
                g[1] += j1 * r
                g[2] += j2 * r
                h[0, 0] += j0 * j0
                h[0, 1] += j0 * j1
                h[0, 2] += j0 * j2
                h[1, 1] += j1 * j1
                h[1, 2] += j1 * j2
                h[2, 2] += j2 * j2
        step = _solve3(h, g, damping)
        p, m, s = peak + step[0], position + step[1], width + step[2]
        trial = _squares(row, p, m, s) if p > 0 and s > 0 else np.inf
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
    return peak, position, width, cost


@compiled()
def _solve3(h: NDArray[np.float64], g: NDArray[np.float64], damping: float) -> tuple[float, float, float]:
    """Solve the damped symmetric 3 x 3 system of which the upper half is given, by Cramer's rule."""
    a, b, c = h[0, 0] * (1 + damping), h[0, 1], h[0, 2]
    d, e, f = h[1, 1] * (1 + damping), h[1, 2], h[2, 2] * (1 + damping)
    c0, c1, c2 = d * f - e * e, c * e - b * f, b * e - c * d
    det = a * c0 + b * c1 + c * c2
    if det == 0:
        return 0.0, 0.0, 0.0
    return (
        (g[0] * c0 + g[1] * c1 + g[2] * c2) / det,
        (g[0] * c1 + g[1] * (a * f - c * c) + g[2] * (b * c - a * e)) / det,
        (g[0] * c2 + g[1] * (b * c - a * e) + g[2] * (a * d - b * b)) / det,
    )


@compiled()
def _fit(values: NDArray[np.float64], iterate: bool, out: NDArray[np.float64]) -> None:
    """Fit every row; each depends on itself alone."""
    for i in range(len(values)):
        row = values[i]
        peak, position, width, count = _closed(row)
        residual = np.nan
        if not np.isnan(peak):
            if iterate:
                peak, position, width, squares = _refine(row, peak, position, width)
            else:
                squares = _squares(row, peak, position, width)
            residual = np.sqrt(squares / count) / peak
        out[i, 0] = peak
        out[i, 1] = position
        out[i, 2] = width
        out[i, 3] = residual

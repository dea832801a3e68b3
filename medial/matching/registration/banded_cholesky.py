"""Solution of positive definite systems whose lower triangle has a ragged band; compiled.

scipy's ``solveh_banded`` takes one width for all rows. It is as fast for 80 nodes (480 unknowns), less than
half as fast for 200, and needs a copy into diagonals: ``python -m tests.benchmarks.banded_systems``.
"""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled

Float = NDArray[np.float64]
Int = NDArray[np.int64]


@compiled()
def cholesky_solve(system: Float, right: Float) -> Float:
    """Solution of a positive definite system of which the lower triangle is given; it is overwritten.

    A row of the factor starts where that of the system does, so that the cost grows with the square of the
    bandwidth, not of the size: nodes are numbered along the body.

    Parameters
    ----------
    system : (k, k) float64
        Changed in place.
    right : (k,) float64

    Returns
    -------
    (k,) float64
    """
    first, x = np.zeros(len(right), np.int64), right.copy()
    for i in range(len(right)):
        row, start = system[i], 0
        while start < i and row[start] == 0:
            start += 1
        first[i] = start
        for j in range(start, i):
            common = max(start, first[j])
            row[j] = (row[j] - _dot(row[common:j], system[j, common:j])) / system[j, j]
        row[i] = np.sqrt(row[i] - _dot(row[start:i], row[start:i]))
        x[i] = (x[i] - _dot(row[start:i], x[start:i])) / row[i]
    for i in range(len(right) - 1, -1, -1):
        x[i] /= system[i, i]
        for k in range(first[i], i):
            x[k] -= system[i, k] * x[i]
    return x


@compiled()
def _dot(a: Float, b: Float) -> float:
    total = 0.0
    for k in range(len(a)):
        total += a[k] * b[k]
    return total

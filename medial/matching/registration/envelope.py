"""Positive definite systems of a deformation graph in envelope storage [GL81], and their solution; compiled.

Nodes are numbered along the body, so that a row of the lower triangle starts not far from its diagonal. Only
what lies between is stored, and the factor fits in there as well: for 80 nodes an eighth of the matrix. Time
grows with the square of the width of rows, and memory with the width, not the size.

Rows of two nodes form a *strip*, which starts where the longer one does. The twelve numbers of a column lie
side by side, so that the processor handles several at once.

scipy's ``solveh_banded`` takes one width for all rows and gives other last digits with another BLAS:
``python -m tests.benchmarks.banded_systems`` compares times.

References
----------
[GL81] George, Liu: Computer solution of large sparse positive definite systems. Prentice-Hall, 1981.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled

Float = NDArray[np.float64]
Int = NDArray[np.int64]

STRIP = 2
"""Nodes of a strip."""
HEIGHT = 12
"""Rows of a strip, and numbers in a column of it: a node moves by six."""
BLOCK = 72
"""Numbers in the six columns of a node."""


@dataclass(frozen=True)
class Envelope:
    """Which blocks of a system of N nodes are stored, and where.

    Row p of node i has the column q of node j at ``origin[i] + 72 j + 12 q + p`` of the values.

    Attributes
    ----------
    lowest : (N,) int64
        Node of the first block of each row; not above the row.
    """

    lowest: Int

    @cached_property
    def origin(self) -> Int:
        """Where the first row of each node has column 0, or would have it, (N,)."""
        nodes = np.arange(len(self.lowest))
        return np.asarray(self._start[nodes // STRIP] - BLOCK * self.first + 6 * (nodes % STRIP))

    @cached_property
    def diagonal(self) -> Int:
        """Where the diagonal of the system is, (6 N,)."""
        nodes = np.arange(len(self.lowest))
        return np.asarray((self.origin + BLOCK * nodes)[:, None] + (HEIGHT + 1) * np.arange(6)).ravel()

    def zeros(self) -> Float:
        """Values of a system of zeros."""
        return np.zeros(self._start[-1])

    def dense(self, values: Float) -> Float:
        """The lower triangle of a system as a matrix, (6 N, 6 N)."""
        count = len(self.lowest)
        matrix = np.zeros((HEIGHT * (len(self._start) - 1), 6 * count))
        for k, low in enumerate(self.first[::STRIP]):
            start, stop = self._start[k : k + 2]
            columns = values[start:stop].reshape(-1, HEIGHT)[: 6 * (count - low)]
            matrix[HEIGHT * k : HEIGHT * (k + 1), 6 * low : 6 * low + len(columns)] = columns.T
        return np.tril(matrix[: 6 * count])

    @cached_property
    def first(self) -> Int:
        """Node of the first column that is stored of each node's strip, (N,)."""
        nodes = np.arange(len(self.lowest))
        return np.asarray(np.minimum.reduceat(self.lowest, nodes[::STRIP])[nodes // STRIP])

    @cached_property
    def _start(self) -> Int:
        """Where each strip starts, and the last one ends."""
        lowest = self.first[::STRIP]
        nodes = STRIP * np.arange(1, len(lowest) + 1) - lowest
        return np.concatenate([np.zeros(1, np.int64), BLOCK * np.cumsum(nodes)])


def solve(values: Float, right: Float, envelope: Envelope) -> Float:
    """Solution of the (slightly damped) system; its values are overwritten.

    Parameters
    ----------
    values
        As laid out by the envelope.
    right : (6 N,)
    envelope

    Returns
    -------
    (6 N,) float64
    """
    diagonal = envelope.diagonal
    values[diagonal] += 1e-6 * values[diagonal].sum() / len(diagonal) + 1e-12
    return np.asarray(cholesky_solve(values, right, envelope.first, envelope.origin))


@compiled()
def cholesky_solve(values: Float, right: Float, first: Int, origin: Int) -> Float:
    """Solution of a positive definite system, (6 N,); its values are overwritten by the Cholesky factor.

    Parameters
    ----------
    values
        What lies above the diagonal is not read.
    right : (6 N,)
    first, origin : (N,)
        Of the `Envelope`.
    """
    count, sums = len(first), np.zeros((6, HEIGHT))
    for i in range(0, count, STRIP):
        for j in range(first[i], min(i + STRIP, count)):
            shared = max(first[i], first[j])
            _products(sums, values, origin[i] + BLOCK * shared, origin[j] + BLOCK * shared, j - shared)
            _finish_columns(sums, values, origin[i] + BLOCK * j, origin[j] + BLOCK * j, j >= i)
    x = right.copy()
    _solve_lower(x, values, first, origin)
    _solve_upper(x, values, first, origin)
    return x


@compiled()
def _products(sums: Float, values: Float, strip: int, row: int, nodes: int) -> None:
    """Sums over the columns of some nodes: of a strip's rows times six other rows.

    Parameters
    ----------
    sums : (6, 12)
        Written; transposed.
    values
        With columns of the factor.
    strip, row
        Where the first column has the first row of the strip, and the first of the six rows.
    nodes
        How many nodes have their columns summed, one after the other: the order in which numbers are added
        decides their last digits.
    """
    sums[:] = 0.0
    for _ in range(nodes):
        a = values[strip : strip + HEIGHT]
        b = values[strip + HEIGHT : strip + 2 * HEIGHT]
        c = values[strip + 2 * HEIGHT : strip + 3 * HEIGHT]
        d = values[strip + 3 * HEIGHT : strip + 4 * HEIGHT]
        e = values[strip + 4 * HEIGHT : strip + 5 * HEIGHT]
        f = values[strip + 5 * HEIGHT : strip + 6 * HEIGHT]
        for q in range(6):
            total, at = sums[q], row + q
            u, v, w = values[at], values[at + HEIGHT], values[at + 2 * HEIGHT]
            x, y, z = values[at + 3 * HEIGHT], values[at + 4 * HEIGHT], values[at + 5 * HEIGHT]
            for p in range(len(total)):
                half = total[p] + a[p] * u + b[p] * v + c[p] * w
                total[p] = half + d[p] * x + e[p] * y + f[p] * z
        strip += BLOCK
        row += BLOCK


@compiled()
def _finish_columns(sums: Float, values: Float, strip: int, pivot: int, own: bool) -> None:
    """Turn the columns of a node in a strip into those of the factor.

    Parameters
    ----------
    sums : (6, 12)
        Of products of the columns before; changed.
    values
    strip
        Where the columns start.
    pivot
        Where the node's block on the diagonal starts.
    own
        Whether that is in this strip, and not in one before.
    """
    for q in range(6):
        total, at = sums[q], pivot + HEIGHT * q + q
        column = values[strip + HEIGHT * q : strip + HEIGHT * (q + 1)]
        for k in range(q):
            earlier = values[strip + HEIGHT * k : strip + HEIGHT * (k + 1)]
            factor = values[pivot + HEIGHT * k + q]
            for p in range(len(total)):
                total[p] += earlier[p] * factor
        for p in range(len(total)):
            column[p] -= total[p]
        if own:
            values[at] = np.sqrt(values[at])
        root = values[at]
        for p in range(len(total)):
            column[p] /= root
        values[at] = root


@compiled()
def _solve_lower(x: Float, values: Float, first: Int, origin: Int) -> None:
    """Solve L x = b in place for the factor L."""
    total = np.zeros(HEIGHT)
    for i in range(0, len(first), STRIP):
        start, last = 6 * i, min(HEIGHT, len(x) - 6 * i)
        total[:] = 0.0
        for k in range(6 * first[i], start + last):
            column = values[origin[i] + HEIGHT * k : origin[i] + HEIGHT * (k + 1)]
            if k >= start:
                x[k] = (x[k] - total[k - start]) / column[k - start]
            for p in range(len(total)):
                total[p] += column[p] * x[k]


@compiled()
def _solve_upper(x: Float, values: Float, first: Int, origin: Int) -> None:
    """Solve L^T x = b in place for the factor L."""
    for i in range((len(first) - 1) // STRIP * STRIP, -1, -STRIP):
        start, last = 6 * i, min(HEIGHT, len(x) - 6 * i)
        for k in range(start + last - 1, 6 * first[i] - 1, -1):
            column, total = values[origin[i] + HEIGHT * k : origin[i] + HEIGHT * (k + 1)], x[k]
            for p in range(last - 1, max(k - start, -1), -1):
                total -= column[p] * x[start + p]
            x[k] = total / column[k - start] if k >= start else total

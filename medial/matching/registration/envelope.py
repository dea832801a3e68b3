"""Positive definite systems of a deformation graph in envelope storage [GL81], and their solution; compiled.

Nodes are numbered along the body, so that a row of the lower triangle starts not far from its diagonal. Only
what lies between is stored, in blocks of 6 x 6, and the factor fits in there as well: for 80 nodes a tenth of
the matrix. Time grows with the square of the width of rows, and memory with the width, not the size.

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

BLOCK = 36
"""Numbers in a block: a node moves by six."""


@dataclass(frozen=True)
class Envelope:
    """Which blocks of a system of N nodes are stored, and where.

    Block row i holds the blocks (i, j) for j from ``lowest[i]`` to i. The block (i, j) starts at
    ``origin[i] + 36 j`` of the values, column by column.

    Attributes
    ----------
    lowest : (N,) int64
        Node of the first block of each row; not above the row.
    """

    lowest: Int

    @cached_property
    def origin(self) -> Int:
        """Where the block of each row with node 0 starts, or would start, (N,)."""
        return self._start[:-1] - BLOCK * self.lowest

    @cached_property
    def diagonal(self) -> Int:
        """Where the diagonal of the system is, (6 N,)."""
        nodes = np.arange(len(self.lowest))
        return np.asarray((self.origin + BLOCK * nodes)[:, None] + 7 * np.arange(6)).ravel()

    def zeros(self) -> Float:
        """Values of a system of zeros."""
        return np.zeros(self._start[-1])

    def dense(self, values: Float) -> Float:
        """The lower triangle of a system as a matrix, (6 N, 6 N)."""
        count = len(self.lowest)
        matrix = np.zeros((count, 6, count, 6))
        for i, (low, start) in enumerate(zip(self.lowest, self._start, strict=False)):
            row = values[start : start + BLOCK * (i + 1 - low)]
            matrix[i, :, low : i + 1] = row.reshape(-1, 6, 6).transpose(2, 0, 1)
        return np.tril(matrix.reshape(6 * count, 6 * count))

    @cached_property
    def _start(self) -> Int:
        widths = np.arange(len(self.lowest)) - self.lowest + 1
        return np.concatenate([np.zeros(1, np.int64), BLOCK * np.cumsum(widths)])


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
    return np.asarray(cholesky_solve(values, right, envelope.lowest, envelope.origin))


@compiled()
def cholesky_solve(values: Float, right: Float, lowest: Int, origin: Int) -> Float:
    """Solution of a positive definite system, (6 N,); its values are overwritten by the Cholesky factor.

    Parameters
    ----------
    values
        Of blocks on the diagonal, only the lower triangle is read.
    right : (6 N,)
    lowest, origin : (N,)
        Of the `Envelope`.
    """
    x, sums = right.copy(), np.zeros((6, 6))
    for i in range(len(lowest)):
        for j in range(lowest[i], i + 1):
            first, row, above = max(lowest[i], lowest[j]), origin[i], origin[j]
            _products(sums, values, row + BLOCK * first, above + BLOCK * first, 6 * (j - first))
            _finish_block(sums, values, row + BLOCK * j, above + BLOCK * j, i == j)
        for p in range(6):
            at, total = origin[i] + p, 0.0
            for k in range(6 * lowest[i], 6 * i + p):
                total += values[at + 6 * k] * x[k]
            x[6 * i + p] = (x[6 * i + p] - total) / values[at + 6 * (6 * i + p)]
    for k in range(len(x) - 1, -1, -1):
        at = origin[k // 6] + k % 6
        x[k] /= values[at + 6 * k]
        for j in range(6 * lowest[k // 6], k):
            x[j] -= values[at + 6 * j] * x[k]
    return x


@compiled()
def _products(sums: Float, values: Float, row: int, above: int, count: int) -> None:
    """Sums over `count` columns of the factor: of six rows from `row` times six rows from `above`.

    Writes the transposed block, (6, 6).
    """
    sums[:] = 0.0
    for _ in range(count):
        for q in range(6):
            factor = values[above + q]
            for p in range(6):
                sums[q, p] += values[row + p] * factor
        row += 6
        above += 6


@compiled()
def _finish_block(sums: Float, values: Float, block: int, pivot: int, diagonal: bool) -> None:
    """Turn a block into one of the factor.

    Parameters
    ----------
    sums
        Of products of the columns before; changed.
    values
    block
        Where it starts.
    pivot
        Where the block on the diagonal in its columns starts; the same if it is on the `diagonal`.
    """
    for q in range(6):
        for k in range(q):
            factor = values[pivot + 6 * k + q]
            for p in range(6):
                sums[q, p] += values[block + 6 * k + p] * factor
        for p in range(6):
            values[block + 6 * q + p] -= sums[q, p]
        if diagonal:
            values[block + 7 * q] = np.sqrt(values[block + 7 * q])
        for p in range(q + 1 if diagonal else 0, 6):
            values[block + 6 * q + p] /= values[pivot + 7 * q]

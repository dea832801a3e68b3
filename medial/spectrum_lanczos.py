"""Chebyshev-filtered block Lanczos for a few hundred of the smallest eigenpairs of a sparse symmetric matrix.

A Chebyshev polynomial of the matrix maps the unwanted part of the spectrum [edge, top] into [-1, 1] and blows
up what lies below the edge, so that a Krylov space of about 1.6 vectors per wanted pair suffices [Zhou & Saad
2007]. The edge is placed where the spectral density, estimated by stochastic Lanczos quadrature [Lin, Saad &
Yang 2016], counts 1.25 times the pairs wanted: an edge placed exactly at the last one converges slowly.
"""

import logging
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from medial.compiled import compiled, ranges, run_tasks

log = logging.getLogger(__name__)

BLOCK = 16
PROBE_STEPS = 24
SURPLUS = 1.25  # eigenvalues below the edge, per wanted one
DEGREE = 4.0  # of the polynomial, times sqrt(top / edge)
DEGREES = (4, 200)
FIRST_CHECK = 1.3  # vectors per wanted pair before convergence is tested
CHECK_EVERY = 3  # blocks
LARGEST_SPACE, SMALLEST_SPACE = 4, 160  # vectors per wanted pair, and besides
RESTARTS = 3
ROWS_PER_TASK = 2048

Array = NDArray[np.float64]


def filtered_lanczos(
    matrix: csr_array, count: int, known: Array, tolerance: float, start: Array | None = None
) -> tuple[Array, Array, float]:
    """The `count` smallest eigenpairs orthogonal to `known` ones.

    Parameters
    ----------
    matrix : (n, n) csr_array
        Symmetric, positive semidefinite.
    count
        How many.
    known : (n, j)
        Orthonormal eigenvectors to leave out.
    tolerance
        Largest residual relative to the largest eigenvalue.
    start : (n, m), optional
        Approximate eigenvectors.

    Returns
    -------
    values : (count,)
    vectors : (n, count)
    residual : float
        Largest residual reached, relative to the largest eigenvalue.
    """
    n = matrix.shape[0]
    random = np.random.default_rng(0)
    ritz, weights, top = _density(matrix, random.standard_normal((n, BLOCK)))
    order = np.argsort(ritz)
    below = np.cumsum(weights[order]) * n - known.shape[1]
    edge = float(np.interp(SURPLUS * count + 2 * BLOCK, below, ritz[order]))
    largest = min(LARGEST_SPACE * count + SMALLEST_SPACE, n - known.shape[1] - BLOCK)
    for _ in range(RESTARTS):
        edge = min(max(edge, 1e-7 * top), 0.9 * top)
        degree = int(np.clip(round(DEGREE * np.sqrt(top / edge)), *DEGREES))
        first = random.standard_normal((n, BLOCK))
        if start is not None:
            first = 1e-3 * first / np.sqrt(n) + start @ random.standard_normal((start.shape[1], BLOCK))
        basis, converged = _krylov(matrix, first, known, count, degree, edge, top, tolerance, largest)
        values, vectors, residual = _rayleigh_ritz(matrix, basis)
        residuals = residual[:count].max()
        if converged and residuals <= tolerance * top:
            break
        start, edge = vectors, float(values[-1])  # the space held too little below a misplaced edge
    else:
        log.warning("%d modes have a residual of %.1e (asked: %.1e)", count, residuals / top, tolerance)
    return values[:count], vectors[:, :count], float(residuals / top)


def _density(matrix: csr_array, probes: Array) -> tuple[Array, Array, float]:
    """Stochastic Lanczos quadrature: nodes and weights of the density, and a bound of the spectrum."""
    count = probes.shape[1]
    current = probes / np.linalg.norm(probes, axis=0)
    previous = np.zeros_like(current)
    diagonal, off = np.zeros((PROBE_STEPS, count)), np.zeros((PROBE_STEPS, count))
    for step in range(PROBE_STEPS):
        product = multiply(matrix, current)
        diagonal[step] = np.einsum("ij,ij->j", product, current)
        product -= diagonal[step] * current + (off[step - 1] * previous if step else 0.0)
        off[step] = np.linalg.norm(product, axis=0)
        previous, current = current, product / np.where(off[step] > 0, off[step], 1.0)
    nodes, weights, top = [], [], 0.0
    for k in range(count):
        tridiagonal = np.diag(diagonal[:, k]) + np.diag(off[:-1, k], 1) + np.diag(off[:-1, k], -1)
        values, vectors = np.linalg.eigh(tridiagonal)
        nodes.append(values)
        weights.append(vectors[0] ** 2 / count)
        top = max(top, float((values + off[-1, k] * np.abs(vectors[-1])).max()))
    return np.concatenate(nodes), np.concatenate(weights), 1.01 * top


def _krylov(
    matrix: csr_array, first: Array, known: Array, count: int, degree: int, edge: float, top: float,
    tolerance: float, largest: int,
) -> tuple[Array, bool]:  # fmt: skip
    """Orthonormal basis of the wanted Ritz vectors, and whether they converged."""
    n = matrix.shape[0]
    basis = np.zeros((n, largest + BLOCK), order="F")
    projected = np.zeros((largest, largest))
    basis[:, :BLOCK] = np.linalg.qr(_without(known, first))[0]
    size = BLOCK
    while True:
        last = np.ascontiguousarray(basis[:, size - BLOCK : size])
        image = _without(known, chebyshev(matrix, last, degree, edge, top))
        overlap = _inner(basis[:, :size], image)
        image = _subtract(image, basis[:, :size], overlap)
        again = _inner(basis[:, :size], image)  # once more: rounding left overlaps
        image = _subtract(image, basis[:, :size], again)
        overlap += again
        projected[:size, size - BLOCK : size] = overlap
        projected[size - BLOCK : size, :size] = overlap.T
        following, remainder = np.linalg.qr(image)
        blocks = size // BLOCK
        due = size >= FIRST_CHECK * count and blocks % CHECK_EVERY == 0
        if due or size + BLOCK > largest:
            vectors, error = _wanted(projected[:size, :size], remainder, count, degree, edge, top)
            if error <= tolerance * top or size + BLOCK > largest:
                return _combine(basis[:, :size], vectors), error <= tolerance * top
        basis[:, size : size + BLOCK] = _renewed(following, remainder, basis[:, :size], known)
        size += BLOCK


def _wanted(
    projected: Array, remainder: Array, count: int, degree: int, edge: float, top: float
) -> tuple[Array, float]:
    """Coefficients of the wanted Ritz vectors and some more, and the largest residual of the wanted ones.

    The residual is that of the matrix itself: what is wrong with a Ritz vector lies above the edge, where
    |p| <= 1, so a residual e of the filtered matrix is one of at most e (top - lambda) / (p(lambda) - 1).
    """
    sign = 1 if degree % 2 == 0 else -1
    values, vectors = np.linalg.eigh(sign * (projected + projected.T) / 2)
    kept = vectors[:, max(len(values) - int(SURPLUS * count) - BLOCK, 0) :]
    chosen = slice(max(len(values) - count, 0), None)
    residuals = np.linalg.norm(remainder @ vectors[-BLOCK:, chosen], axis=0)
    x = np.cosh(np.arccosh(np.maximum(values[chosen], 1 + 1e-6)) / degree)
    lowest = (top + edge) / 2 - x * (top - edge) / 2
    gain = np.maximum(values[chosen] - 1, 1e-6) / (top - lowest)
    return kept, float((residuals / gain).max()) if len(values) >= count else np.inf


def _renewed(following: Array, remainder: Array, basis: Array, known: Array) -> Array:
    """The next block, with random directions in place of those in which the Krylov space has ended."""
    ended = np.abs(np.diag(remainder)) <= 1e-12 * max(np.abs(remainder).max(), 1e-300)
    if not ended.any():
        return following
    block = following.copy()
    block[:, ended] = np.random.default_rng(basis.shape[1]).standard_normal((len(block), int(ended.sum())))
    for _ in range(2):
        block = _without(known, _subtract(block, basis, _inner(basis, block)))
        block = np.linalg.qr(block)[0]
    return block


def _rayleigh_ritz(matrix: csr_array, basis: Array) -> tuple[Array, Array, Array]:
    """Eigenpairs of the matrix restricted to a space, and the residual of each."""
    images = np.empty_like(basis)
    for start, stop in ranges(basis.shape[1], BLOCK):
        images[:, start:stop] = multiply(matrix, np.ascontiguousarray(basis[:, start:stop]))
    projected = _inner(basis, images)
    values, rotation = np.linalg.eigh((projected + projected.T) / 2)
    vectors, images = _combine(basis, rotation), _combine(images, rotation)
    images -= vectors * values
    return values, vectors, np.linalg.norm(images, axis=0)


def chebyshev(matrix: csr_array, block: Array, degree: int, edge: float, top: float) -> Array:
    """T_degree of the matrix, with [edge, top] mapped to [-1, 1], times a block of vectors."""
    center, half = (top + edge) / 2, (top - edge) / 2
    before, now = block, multiply(matrix, block, 1 / half, center)
    for _ in range(degree - 1):
        before, now = now, multiply(matrix, now, 2 / half, center, before)
    return now


def multiply(
    matrix: csr_array, block: Array, factor: float = 1.0, shift: float = 0.0, minus: Array | None = None
) -> Array:
    """``factor * (matrix - shift) @ block - minus`` in one pass over the matrix."""
    out = np.empty_like(block)
    if minus is None:
        minus, keep = block, 0.0
    else:
        keep = 1.0
    arrays = (matrix.indptr, matrix.indices, matrix.data, block, minus, out, factor, shift, keep)
    run_tasks(_rows, [(*arrays, *span) for span in ranges(len(block), ROWS_PER_TASK)])
    return out


@compiled(fastmath={"contract"})
def _rows(
    indptr: Any, indices: Any, data: Any, block: Any, minus: Any, out: Any, factor: float, shift: float,
    keep: float, start: int, stop: int,
) -> None:  # fmt: skip
    """Rows [start, stop) of `multiply`; four entries at a time keep the sums out of each other's way."""
    width = block.shape[1]
    total = np.zeros(width)
    for row in range(start, stop):
        for k in range(width):
            total[k] = -shift * block[row, k]
        entry, end = indptr[row], indptr[row + 1]
        while entry + 4 <= end:
            a, b, c, d = data[entry], data[entry + 1], data[entry + 2], data[entry + 3]
            p, q = block[indices[entry]], block[indices[entry + 1]]
            r, s = block[indices[entry + 2]], block[indices[entry + 3]]
            for k in range(width):
                total[k] += (a * p[k] + b * q[k]) + (c * r[k] + d * s[k])
            entry += 4
        while entry < end:
            p = block[indices[entry]]
            for k in range(width):
                total[k] += data[entry] * p[k]
            entry += 1
        for k in range(width):
            out[row, k] = factor * total[k] - keep * minus[row, k]


def _without(known: Array, block: Array) -> Array:
    for _ in range(2):
        block = block - known @ (known.T @ block)
    return block


def _inner(a: Array, b: Array) -> Array:
    """``a.T @ b`` from fixed pieces of rows: the sum does not depend on the number of threads."""
    spans = ranges(len(a), ROWS_PER_TASK)
    parts: list[Array] = run_tasks(lambda start, stop: a[start:stop].T @ b[start:stop], spans)
    return np.sum(parts, axis=0)


def _subtract(block: Array, basis: Array, coefficients: Array) -> Array:
    """``block - basis @ coefficients``."""
    return block - _combine(basis, coefficients)


def _combine(basis: Array, coefficients: Array) -> Array:
    """``basis @ coefficients`` by pieces of rows."""
    out = np.empty((len(basis), coefficients.shape[1]))

    def rows(start: int, stop: int) -> None:
        np.matmul(basis[start:stop], coefficients, out=out[start:stop])

    run_tasks(rows, ranges(len(basis), ROWS_PER_TASK))
    return out

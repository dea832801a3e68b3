"""Block Krylov spaces: a few hundred extreme eigenpairs of a symmetric operator, block by block.

Everything that touches all rows is done on fixed pieces of rows, on our own threads with one BLAS thread
each: the result does not depend on the number of threads.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from datasets_gen.compiled import compiled, ranges, run_tasks

BLOCK = 16
FIRST_CHECK = 1.3  # vectors per wanted pair before convergence is tested
CHECK_EVERY = 2  # blocks
SURPLUS = 1.25  # Ritz vectors returned, per wanted one
ROWS_PER_TASK = 2048

Array = NDArray[np.float64]


def largest_ritz(
    apply: Callable[[Array], Array],
    first: Array,
    known: Array,
    count: int,
    error: Callable[[Array, Array], float],
    largest: int,
) -> tuple[Array, Array, bool]:
    """Ritz vectors of the `count` largest eigenvalues, by block Lanczos with full orthogonalisation.

    Parameters
    ----------
    apply
        The symmetric operator, on blocks of 16 vectors.
    first : (n, 16)
        Starting block.
    known : (n, j)
        Orthonormal vectors to stay orthogonal to.
    count
        How many.
    error
        Of the `count` largest Ritz values and their residuals: at most 1 when converged.
    largest
        Most vectors in the space.

    Returns
    -------
    space : (n, m)
        Orthonormal basis.
    coefficients : (m, >= count)
        Of the Ritz vectors, the wanted ones last.
    converged : bool
    """
    basis = np.zeros((len(first), largest + BLOCK), order="F")
    projected = np.zeros((largest, largest))
    basis[:, :BLOCK] = np.linalg.qr(without(known, first))[0]
    size = BLOCK
    while True:
        image = without(known, apply(np.ascontiguousarray(basis[:, size - BLOCK : size])))
        recent = slice(max(size - 2 * BLOCK, 0), size)  # in exact arithmetic the image meets no other block
        local = inner(basis[:, recent], image)
        image = _subtract(image, basis[:, recent], local)
        overlap = inner(basis[:, :size], image)
        image = _subtract(image, basis[:, :size], overlap)
        overlap[recent] += local
        projected[:size, size - BLOCK : size] = overlap
        projected[size - BLOCK : size, :size] = overlap.T
        following, remainder = np.linalg.qr(image)
        due = size >= FIRST_CHECK * count and size // BLOCK % CHECK_EVERY == 0
        full = size + BLOCK > largest
        if due or full:
            values, vectors = np.linalg.eigh((projected[:size, :size] + projected[:size, :size].T) / 2)
            residuals = np.linalg.norm(remainder @ vectors[-BLOCK:, -count:], axis=0)
            converged = size >= count and error(values[-count:], residuals) <= 1
            if converged or full:
                return basis[:, :size], vectors[:, -int(SURPLUS * count) - BLOCK :], converged
        basis[:, size : size + BLOCK] = _renewed(following, remainder, basis[:, :size], known)
        size += BLOCK


def _renewed(following: Array, remainder: Array, basis: Array, known: Array) -> Array:
    """The next block, with random directions in place of those in which the Krylov space has ended."""
    ended = np.abs(np.diag(remainder)) <= 1e-12 * max(np.abs(remainder).max(), 1e-300)
    if not ended.any():
        return following
    block = following.copy()
    block[:, ended] = np.random.default_rng(basis.shape[1]).standard_normal((len(block), int(ended.sum())))
    for _ in range(2):
        block = without(known, _subtract(block, basis, inner(basis, block)))
        block = np.linalg.qr(block)[0]
    return block


def finished(matrix: csr_array, vectors: Array) -> tuple[Array, Array, float]:
    """Rayleigh quotients of converged Ritz vectors in ascending order, and the largest residual."""
    images = _images(matrix, vectors)
    values = np.einsum("ij,ij->j", vectors, images)
    images -= vectors * values
    order = np.argsort(values, kind="stable")
    return values[order], vectors[:, order], float(np.linalg.norm(images, axis=0).max())


def rayleigh_ritz(matrix: csr_array, basis: Array, count: int) -> tuple[Array, Array, float]:
    """Eigenpairs of the matrix restricted to a space, and the largest residual of the first `count`."""
    projected = inner(basis, _images(matrix, basis))
    rotation = np.linalg.eigh((projected + projected.T) / 2)[1]
    values, vectors, _ = finished(matrix, combine_columns(basis, rotation))
    return values, vectors, finished(matrix, vectors[:, :count])[2]


def _images(matrix: csr_array, vectors: Array) -> Array:
    images = np.empty_like(vectors)
    block = np.zeros((len(vectors), BLOCK))
    for start, stop in ranges(vectors.shape[1], BLOCK):
        block[:, : stop - start] = vectors[:, start:stop]
        images[:, start:stop] = multiply(matrix, block)[:, : stop - start]
    return images


def multiply(
    matrix: csr_array, block: Array, factor: float = 1.0, shift: float = 0.0, minus: Array | None = None
) -> Array:
    """``factor * (matrix - shift) @ block - minus`` in one pass over the matrix; the block has 16 columns."""
    out = np.empty_like(block)
    keep = 0.0 if minus is None else 1.0
    unsigned = np.dtype(f"u{matrix.indices.itemsize}")  # spares the kernel the test for negative indices
    arrays = (matrix.indptr.view(unsigned), matrix.indices.view(unsigned), matrix.data, block)
    more = (block if minus is None else minus, out, factor, shift, keep)
    run_tasks(_rows, [(*arrays, *more, *span) for span in ranges(len(block), ROWS_PER_TASK)])
    return out


@compiled()
def _rows(
    indptr: Any, indices: Any, data: Any, block: Any, minus: Any, out: Any, factor: float, shift: float,
    keep: float, start: int, stop: int,
) -> None:  # fmt: skip
    """Rows [start, stop) of `multiply`; eight entries at a time keep the sums out of each other's way."""
    total = np.zeros(BLOCK)
    one, eight = indptr.dtype.type(1), indptr.dtype.type(8)
    for row in range(start, stop):
        for k in range(BLOCK):
            total[k] = -shift * block[row, k]
        e, end = indptr[row], indptr[row + 1]
        while e + eight <= end:
            a, b, c, d = data[e], data[e + 1], data[e + 2], data[e + 3]
            f, g, h, i = data[e + 4], data[e + 5], data[e + 6], data[e + 7]
            p, q, r, s = indices[e], indices[e + 1], indices[e + 2], indices[e + 3]
            t, u, v, w = indices[e + 4], indices[e + 5], indices[e + 6], indices[e + 7]
            for k in range(BLOCK):
                low = (a * block[p, k] + b * block[q, k]) + (c * block[r, k] + d * block[s, k])
                high = (f * block[t, k] + g * block[u, k]) + (h * block[v, k] + i * block[w, k])
                total[k] += low + high
            e += eight
        while e < end:
            p = indices[e]
            for k in range(BLOCK):
                total[k] += data[e] * block[p, k]
            e += one
        for k in range(BLOCK):
            out[row, k] = factor * total[k] - keep * minus[row, k]


def without(known: Array, block: Array) -> Array:
    """The part of a block orthogonal to `known` vectors."""
    for _ in range(2):
        block = block - known @ (known.T @ block)
    return block


def inner(a: Array, b: Array) -> Array:
    """``a.T @ b`` from fixed pieces of rows: the sum does not depend on the number of threads."""
    spans = ranges(len(a), ROWS_PER_TASK)
    parts: list[Array] = run_tasks(lambda start, stop: a[start:stop].T @ b[start:stop], spans)
    return np.sum(parts, axis=0)


def _subtract(block: Array, basis: Array, coefficients: Array) -> Array:
    """``block - basis @ coefficients``."""
    return block - combine_columns(basis, coefficients)


def combine_columns(basis: Array, coefficients: Array) -> Array:
    """``basis @ coefficients`` by pieces of rows."""
    out = np.empty((len(basis), coefficients.shape[1]))

    def rows(start: int, stop: int) -> None:
        np.matmul(basis[start:stop], coefficients, out=out[start:stop])

    run_tasks(rows, ranges(len(basis), ROWS_PER_TASK))
    return out

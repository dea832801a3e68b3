"""Exact nearest neighbours in tens to hundreds of dimensions, by blocked matrix products.

In 25-150 dimensions kd-trees visit nearly every point; products of single-precision blocks are about ten
times faster. Blocks have a fixed size and each is computed by one thread, so that results do not depend on
the number of threads.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from datasets_gen.compiled import compiled, ranges, run_tasks

BLOCK = 1024
"""Rows of one block; part of the definition of the result, as sums are rounded per block."""

Float32 = NDArray[np.float32]


@cache
def _blas() -> ThreadpoolController:
    return ThreadpoolController()


@contextmanager
def single_blas_thread() -> Iterator[None]:
    """Run the enclosed matrix products on one BLAS thread each: the same rounding on every machine."""
    with _blas().limit(limits=1, user_api="blas"):
        yield


def over_blocks(rows: int, work: Callable[[slice], None], block: int = BLOCK) -> None:
    """Call `work` for consecutive slices of `block` rows, on `thread_count` threads.

    Parameters
    ----------
    rows
        Number of rows to cover.
    work
        Writes the result of its slice; must not touch other rows.
    block
        Rows per slice.
    """
    run_tasks(work, [(slice(start, stop),) for start, stop in ranges(rows, block)])


def nearest(
    queries: NDArray[np.floating], targets: NDArray[np.floating]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Nearest target of every query in the Euclidean norm.

    Parameters
    ----------
    queries : (n, d)
    targets : (m, d)
        Ties go to the target of the lowest index.

    Returns
    -------
    index : (n,) int64
    distance : (n,) float64
        Recomputed from the found pair, so it is free of cancellation.
    """
    centre = targets.mean(axis=0)
    q = np.ascontiguousarray(queries - centre, dtype=np.float32)
    t = np.ascontiguousarray(targets - centre, dtype=np.float32)
    half = 0.5 * np.einsum("md,md->m", t, t)
    transposed = np.ascontiguousarray(t.T)
    index = np.empty(len(q), dtype=np.int64)

    def work(rows: slice) -> None:
        score = half - q[rows] @ transposed  # half the squared distance, up to a constant per query
        index[rows] = score.argmin(axis=1)

    with single_blas_thread():
        over_blocks(len(q), work)
    return index, np.linalg.norm(queries - targets[index], axis=1)


def nearest_sum_of_norms(
    queries: list[NDArray[np.floating]], targets: list[NDArray[np.floating]]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Nearest target where the distance is a sum of Euclidean norms over groups of coordinates (Eq. 17).

    Parameters
    ----------
    queries : list of (n, d)
        One array per group.
    targets : list of (m, d)
        The same groups.

    Returns
    -------
    index : (n,) int64
    distance : (n,) float64
    """
    n, m = len(queries[0]), len(targets[0])
    pairs = []
    for group, other in zip(queries, targets, strict=True):
        centre = other.mean(axis=0)
        q = np.ascontiguousarray(group - centre, dtype=np.float32)
        t = np.ascontiguousarray(other - centre, dtype=np.float32)
        square_q, square_t = np.einsum("nd,nd->n", q, q), np.einsum("md,md->m", t, t)
        pairs.append((q, np.ascontiguousarray(-2 * t.T), square_q, square_t))
    index = np.empty(n, dtype=np.int64)
    distance = np.empty(n)

    def work(rows: slice) -> None:
        total = np.zeros((rows.stop - rows.start, m), dtype=np.float32)
        for q, minus_twice_t, square_q, square_t in pairs:
            _add_norms(total, q[rows] @ minus_twice_t, square_q[rows], square_t)
        index[rows] = total.argmin(axis=1)
        distance[rows] = total.min(axis=1)

    with single_blas_thread():
        over_blocks(n, work, block=256)
    return index, distance


@compiled()
def _add_norms(total: Float32, product: Float32, square_q: Float32, square_t: Float32) -> None:
    for i in range(total.shape[0]):
        for j in range(total.shape[1]):
            square = square_q[i] + square_t[j] + product[i, j]
            total[i, j] += np.sqrt(max(square, np.float32(0)))

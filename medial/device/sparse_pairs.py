"""Symmetric sparse matrices from lists of pairs, sorted on a device."""

from typing import Any

import drjit as dr
import numpy as np
from scipy.sparse import csr_array


def symmetric_on(jit: Any, i: Any, j: Any, values: Any, n: int) -> csr_array:
    """`medial.sparse.symmetric`, from arrays that are on a device; the same to the bit.

    Parameters
    ----------
    jit
        ``drjit.cuda`` or ``drjit.llvm``.
    i, j : (pairs,) UInt32
        Every pair once, i != j; at most 2**30 pairs.
    values : (pairs,) Float64
    n
        Rows of the matrix.
    """
    if not dr.width(values):
        return csr_array((n, n))
    rows, cols = dr.concat((i, j)), dr.concat((j, i))
    order: Any = dr.argsort(cols)
    order = dr.gather(jit.UInt32, order, dr.argsort(dr.gather(jit.UInt32, rows, order)))
    counts = dr.zeros(jit.UInt32, n + 1)
    dr.scatter_add(counts, jit.UInt32(1), rows)
    starts = dr.prefix_sum(counts).numpy().astype(np.int32)
    indices = dr.gather(jit.UInt32, cols, order).numpy().astype(np.int32)
    data = np.array(dr.gather(jit.Float64, dr.concat((values, values)), order).numpy())
    matrix = csr_array((data, indices, starts), shape=(n, n))
    matrix.has_sorted_indices = True
    matrix.has_canonical_format = True
    return matrix

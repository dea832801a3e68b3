"""Symmetric sparse matrices from lists of pairs."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from datasets_gen.compiled import compiled


def symmetric(
    i: NDArray[np.integer], j: NDArray[np.integer], values: NDArray[np.float64], n: int
) -> csr_array:
    """The (n, n) matrix with `values` at (i, j) and (j, i), columns sorted; every pair given once, i != j."""
    index = np.int32 if 2 * len(i) < 2**31 else np.int64
    indptr, indices, data = _fill(i.astype(index), j.astype(index), values, n)
    matrix = csr_array((data, indices, indptr), shape=(n, n))
    matrix.has_sorted_indices = True
    matrix.has_canonical_format = True
    return matrix


@compiled()
def _fill(i: Any, j: Any, values: Any, n: int) -> Any:
    """Rows filled in the order of the pairs, then columns likewise, which sorts every row in linear time."""
    indptr = np.zeros(n + 1, i.dtype)
    for k in range(len(i)):
        indptr[i[k] + 1] += 1
        indptr[j[k] + 1] += 1
    for row in range(n):
        indptr[row + 1] += indptr[row]
    place = np.empty(n, i.dtype)
    for row in range(n):
        place[row] = indptr[row]
    loose, held = np.empty(indptr[n], i.dtype), np.empty(indptr[n])
    for k in range(len(i)):
        a, b = i[k], j[k]
        loose[place[a]], held[place[a]] = b, values[k]
        loose[place[b]], held[place[b]] = a, values[k]
        place[a] += 1
        place[b] += 1
    for row in range(n):
        place[row] = indptr[row]
    indices, data = np.empty_like(loose), np.empty_like(held)
    for row in range(n):
        for entry in range(indptr[row], indptr[row + 1]):
            at = place[loose[entry]]
            place[loose[entry]] += 1
            indices[at], data[at] = row, held[entry]
    return indptr, indices, data

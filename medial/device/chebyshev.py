"""Polynomials of a sparse matrix times blocks of vectors, on a device: what the modes spend their time on."""

from collections.abc import Callable
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

Array = NDArray[np.float64]


def chebyshev_on(jit: Any, matrix: csr_array) -> Callable[[Array, int, float, float], Array]:
    """`medial.spectrum.filtered_lanczos.chebyshev` for one matrix, which is kept on the device.

    Only the block goes there and the result comes back. Double precision, as on the processor; sums run
    along the rows one entry after the other, so the result is the same in every run.

    Parameters
    ----------
    jit
        ``drjit.cuda`` or ``drjit.llvm``.
    matrix : (n, n) csr_array

    Returns
    -------
    function
        Of block (n, k), degree, edge and top.
    """
    starts = dr.opaque(jit.UInt32(matrix.indptr.astype(np.uint32)))
    indices = dr.opaque(jit.UInt32(matrix.indices.astype(np.uint32)))
    data = dr.opaque(jit.Float64(matrix.data))

    def multiply(block: Any, width: Any, factor: float, shift: float, keep: float, minus: Any) -> Any:
        """``factor * (matrix - shift) @ block - keep * minus``, one thread for each entry."""
        entry = dr.arange(jit.UInt32, dr.width(block))
        row = entry // width
        column = entry - row * width
        stop = dr.gather(jit.UInt32, starts, row + 1)

        def add(at: Any, total: Any) -> tuple[Any, Any]:
            place = dr.gather(jit.UInt32, indices, at) * width + column
            return at + 1, dr.fma(
                dr.gather(jit.Float64, data, at), dr.gather(jit.Float64, block, place), total
            )

        first = (dr.gather(jit.UInt32, starts, row), dr.opaque(jit.Float64, -shift) * block)
        total = dr.while_loop(first, lambda at, total: at < stop, add)[1]
        out = dr.opaque(jit.Float64, factor) * total - dr.opaque(jit.Float64, keep) * minus
        dr.eval(out)
        return out

    def transform(block: Array, degree: int, edge: float, top: float) -> Array:
        center, half = (top + edge) / 2, (top - edge) / 2
        width = dr.opaque(jit.UInt32, block.shape[1])
        before = dr.opaque(jit.Float64(np.ascontiguousarray(block).ravel()))
        now = multiply(before, width, 1 / half, center, 0.0, before)
        for _ in range(degree - 1):
            before, now = now, multiply(now, width, 2 / half, center, 1.0, before)
        return np.asarray(now.numpy(), dtype=np.float64).reshape(block.shape)

    return transform

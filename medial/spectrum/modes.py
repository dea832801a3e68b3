"""The smallest modes of S psi = lambda A psi."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from threadpoolctl import threadpool_limits

from datasets_gen.records import InputError
from medial.device.backend import CPU, check_device
from medial.spectrum.filtered_lanczos import filtered_lanczos
from medial.spectrum.krylov import Array
from medial.spectrum.shift_invert import inverse_lanczos

DENSE_POINTS = 1200  # up to here, and below four points per mode, a dense solver is faster


def smallest_modes(
    stiffness: csr_array,
    areas: NDArray[np.float64],
    modes: int,
    tolerance: float = 1e-6,
    *,
    factorise: bool = False,
    device: str = CPU,
) -> tuple[Array, Array, float]:
    """The `modes` smallest eigenpairs of ``S psi = lambda A psi``.

    Constant functions on connected components are known exactly, so they are not searched for: the cloud may
    have any number of components.

    Parameters
    ----------
    stiffness : (n, n) csr_array
        Symmetric, positive semidefinite S with zero row sums.
    areas : (n,)
        Diagonal of A, positive.
    modes
        How many.
    tolerance
        Largest residual relative to the largest eigenvalue.
    factorise
        Invert the matrix (`spectrum.shift_invert`) rather than filter it (`spectrum.filtered_lanczos`): for a
        few entries per row and eigenvalues of any spread, such as surface Laplacians.
    device : {"cpu", "cuda", "llvm"}
        Where the matrix is filtered (`medial.device`); dense and inverted matrices stay on the processor.

    Returns
    -------
    eigenvalues : (k,) float64
        Ascending, >= 0.
    eigenfunctions : (n, k) float64
        ``psi.T @ A @ psi == I``; the sign makes the entry of largest magnitude positive.
    residual : float
        Largest ``|M v - lambda v|`` of M = A^-1/2 S A^-1/2, relative to the largest eigenvalue of M.

    Raises
    ------
    InputError
        If there are not more points than modes, or the device is missing.
    """
    check_device(device)
    n = len(areas)
    _check(modes, n)
    scale = 1 / np.sqrt(areas)
    matrix = symmetric_form(stiffness, scale)
    constants = _constants(matrix, 1 / scale, modes)
    with threadpool_limits(1, user_api="blas"):
        if n <= max(DENSE_POINTS, 4 * modes):
            return _dense(matrix, scale, modes)
        wanted = modes - len(constants.T)
        if wanted == 0:
            values, vectors, residual = np.zeros(0), constants[:, :0], 0.0
        elif factorise:
            values, vectors, residual = inverse_lanczos(matrix, wanted, constants, tolerance)
        else:
            values, vectors, residual = filtered_lanczos(matrix, wanted, constants, tolerance, device)
    values = np.concatenate([np.zeros(len(constants.T)), values])
    return _finish(values, np.concatenate([constants, vectors], axis=1), scale, residual)


def symmetric_form(stiffness: csr_array, scale: NDArray[np.float64]) -> csr_array:
    """A^-1/2 S A^-1/2 for scale = A^-1/2."""
    matrix = csr_array(stiffness).astype(np.float64, copy=True)
    rows = np.repeat(np.arange(len(scale)), np.diff(matrix.indptr))
    matrix.data *= scale[rows] * scale[matrix.indices]
    return matrix


def _check(modes: int, n: int) -> None:
    if not 0 < modes < n:
        raise InputError(f"{modes} modes asked of {n} points; ask for 1 to {n - 1} or give more points")


def _constants(matrix: csr_array, root: NDArray[np.float64], modes: int) -> NDArray[np.float64]:
    """Normalised sqrt(a) on each connected component, the largest first; at most `modes` of them, (n, c)."""
    count, labels = connected_components(matrix, directed=False)
    largest = np.argsort(-np.bincount(labels, weights=root**2, minlength=count), kind="stable")[:modes]
    vectors = np.where(labels[:, None] == largest, root[:, None], 0.0)
    return vectors / np.linalg.norm(vectors, axis=0)


def _dense(matrix: csr_array, scale: NDArray[np.float64], modes: int) -> tuple[Array, Array, float]:
    values, vectors = eigh(matrix.toarray(), subset_by_index=(0, modes - 1))
    return _finish(values, vectors, scale, 0.0)


def _finish(
    values: NDArray[np.float64], vectors: NDArray[np.float64], scale: NDArray[np.float64], residual: float
) -> tuple[Array, Array, float]:
    functions = vectors * scale[:, None]
    largest = functions[np.abs(functions).argmax(axis=0), np.arange(len(values))]
    functions *= np.where(largest < 0, -1.0, 1.0)
    return np.maximum(values, 0.0), functions, residual

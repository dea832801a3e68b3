"""The smallest modes of S psi = lambda A psi."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, diags_array, eye_array
from scipy.sparse.linalg import eigsh

from datasets_gen.records import InputError


def smallest_modes(
    stiffness: csr_array, areas: NDArray[np.float64], modes: int, tolerance: float = 1e-6
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The `modes` smallest eigenpairs of ``S psi = lambda A psi``, ``psi.T @ A @ psi = I``.

    Parameters
    ----------
    stiffness : (n, n) csr_array
        Symmetric, positive semidefinite S.
    areas : (n,)
        Diagonal of A.
    modes
        How many.
    tolerance
        Residual relative to the largest eigenvalue.

    Returns
    -------
    eigenvalues : (modes,) float64, ascending
    eigenfunctions : (n, modes) float64

    Raises
    ------
    InputError
        If there are fewer points than modes.
    """
    n = len(areas)
    if modes >= n:
        raise InputError(f"{modes} modes asked of {n} points; ask for fewer than {n} or give more points")
    scale = 1 / np.sqrt(areas)
    matrix = symmetric_form(stiffness, scale)
    if n <= 1000:
        values, vectors = np.linalg.eigh(matrix.toarray())
        values, vectors = values[:modes], vectors[:, :modes]
    else:
        top = float(abs(matrix).sum(axis=1).max())
        shifted = csr_array(top * eye_array(n, format="csr") - matrix)
        start = np.random.default_rng(0).standard_normal(n)
        values, vectors = eigsh(shifted, k=modes, which="LA", tol=tolerance, v0=start, ncv=2 * modes)
        values = top - values
        order = np.argsort(values)
        values, vectors = values[order], vectors[:, order]
    return np.maximum(values, 0), vectors * scale[:, None]


def sparse_modes(
    stiffness: csr_array, areas: NDArray[np.float64], modes: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """As `smallest_modes`, by factorising: for matrices with a few entries per row, such as surface Laplacians."""
    n = len(areas)
    if modes >= n:
        raise InputError(f"{modes} modes asked of {n} points; ask for fewer than {n} or give more points")
    scale = 1 / np.sqrt(areas)
    matrix = csc_array(symmetric_form(stiffness, scale))
    if n <= 1000:
        values, vectors = np.linalg.eigh(matrix.toarray())
        values, vectors = values[:modes], vectors[:, :modes]
    else:
        shift = -1e-3 * float(matrix.diagonal().mean()) / n
        start = np.random.default_rng(0).standard_normal(n)
        values, vectors = eigsh(matrix, k=modes, sigma=shift, which="LM", v0=start)
        order = np.argsort(values)
        values, vectors = values[order], vectors[:, order]
    return np.maximum(values, 0), vectors * scale[:, None]


def symmetric_form(stiffness: csr_array, scale: NDArray[np.float64]) -> csr_array:
    """A^-1/2 S A^-1/2 for scale = A^-1/2."""
    left = diags_array(scale)
    return csr_array(left @ stiffness @ left)

r"""Eqs. 11-13 as the paper writes them: plain NumPy for small clouds, the reference of `medial.Diffusion`."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def heat_rate(laplacian: Array, f: Array) -> Array:
    r"""Eq. 11: the heat equation, df/dt = -Delta f.

    .. math::

        \Delta_S f(x, t) = -\frac{\partial f(x, t)}{\partial t}

    In the code: nothing steps through time; the eigenpairs of Delta solve the equation for all times at once.

    Parameters
    ----------
    laplacian : (n, n)
        The matrix of Delta (Eq. 8), per unit of time.
    f : (n,)
        Heat at the points.

    Returns
    -------
    (n,)
        Change of heat per unit of time.
    """
    return np.asarray(-laplacian @ f)


def diffused(kernel: Array, f: Array, areas: Array) -> Array:
    r"""Eq. 12: M_t f, the heat after time t, as a sum over the points.

    .. math::

        M_t f(x) = \int_S m_t(x, y)\, f(y)\, dy

    In the code: nothing diffuses a function; matching compares the kernels m_t themselves.

    Parameters
    ----------
    kernel : (n, n)
        m_t (Eq. 13), in one over squared units.
    f : (n,)
        Heat at time 0.
    areas : (n,)
        Dual areas, in squared units.

    Returns
    -------
    (n,)
    """
    return np.asarray(kernel @ (f * areas))


def diffusion_kernel(eigenvalues: Array, eigenfunctions: Array, t: float) -> Array:
    r"""Eq. 13: medial diffusion m_t between all points.

    .. math::

        m_t(x, y) = \sum_i e^{-\lambda_i t}\, \Psi_i(x)\, \Psi_i(y)

    In the code: 300 of the n modes, by default; the others have decayed at the times that are compared. Modes
    below 1e-25 of their start count as gone (`medial.diffusion.decay`): no sum feels them.

    Parameters
    ----------
    eigenvalues : (k,)
        Per unit of time.
    eigenfunctions : (n, k)
        Orthonormal for the areas, in one over units.
    t
        Time.

    Returns
    -------
    (n, n), in one over squared units
    """
    total = np.zeros((len(eigenfunctions), len(eigenfunctions)))
    for value, function in zip(eigenvalues, eigenfunctions.T, strict=True):
        total += np.exp(-value * t) * np.outer(function, function)
    return total

"""The Gaussian baseline: Laplace operator of a cloud from Gaussian weights [BSW09]."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from medial.laplacian import BANDWIDTH, gaussian_weights, laplacian


def heat_laplacian(points: NDArray[np.floating], areas: NDArray[np.float64]) -> csr_array:
    r"""S of the Gaussian operator, in the limit the Laplace-Beltrami operator of the surface.

    (L f)(p) = 4 / (pi h^2) \sum_q a_q exp(-|p - q|^2 / h) (f(p) - f(q)), which is Sec. 2 of [BSW09] with h = 4 t.
    """
    spacing = float(np.sqrt(np.mean(areas)))
    h = BANDWIDTH * spacing**2
    weights = gaussian_weights(points, spacing)
    weights.data *= 4 / (np.pi * h**2)
    return laplacian(weights, areas)

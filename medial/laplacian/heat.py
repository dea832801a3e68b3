"""The Gaussian baseline: Laplace operator of a cloud from Gaussian weights [BSW09]."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from medial.departures import Departures
from medial.laplacian.weights import gaussian_weights, laplacian
from medial.validation import OrientedCloud


def heat_laplacian(cloud: OrientedCloud, areas: NDArray[np.float64], departures: Departures) -> csr_array:
    r"""S of the Gaussian operator, in the limit the Laplace-Beltrami operator of the surface.

    (L f)(p) = \sum_q a_q 4 / (pi h^2) exp(-|p - q|^2 / h) (f(p) - f(q)): Sec. 2 of [BSW09] with h = 4 t.

    Parameters
    ----------
    cloud
    areas : (n,)
        Surface areas (`medial.surface_areas`).
    departures
        As for `medial.laplacian.weights.gaussian_weights`.
    """
    weights, bandwidths = gaussian_weights(cloud.points, areas, cloud.tree, departures)
    weights.data *= 4 / (np.pi * bandwidths**2)
    return laplacian(weights, areas)

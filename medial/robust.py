"""The tufted Laplacian of a point cloud [Sharp & Crane 2020], as the package `robust_laplacian` computes it."""

import numpy as np
import robust_laplacian
from numpy.typing import NDArray
from scipy.sparse import csr_array


def tufted_laplacian(points: NDArray[np.floating]) -> tuple[csr_array, NDArray[np.float64]]:
    """Stiffness (n, n) and lumped masses (n,) of the tufted cover of local triangulations."""
    stiffness, mass = robust_laplacian.point_cloud_laplacian(np.ascontiguousarray(points, dtype=np.float64))
    return csr_array(stiffness), np.asarray(mass.diagonal(), dtype=np.float64)

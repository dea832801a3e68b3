"""The tufted Laplacian of a cloud [Sharp & Crane 2020], as the package `robust_laplacian` computes it."""

import numpy as np
import robust_laplacian
from numpy.typing import NDArray
from scipy.sparse import csr_array

from datasets_gen.records import InputError


def tufted_laplacian(points: NDArray[np.floating]) -> tuple[csr_array, NDArray[np.float64]]:
    """Stiffness (n, n) and lumped masses (n,) of the tufted cover of local triangulations.

    Raises
    ------
    InputError
        If the points cannot be triangulated: all on one line, say.
    """
    try:
        stiffness, mass = robust_laplacian.point_cloud_laplacian(
            np.ascontiguousarray(points, dtype=np.float64)
        )
    except RuntimeError as error:
        reason = str(error).splitlines()[0]
        raise InputError(
            f"no tufted Laplacian of these {len(points)} points ({reason}); remove stray points"
        ) from error
    masses = np.asarray(mass.diagonal(), dtype=np.float64)
    if not (np.isfinite(masses).all() and (masses > 0).all() and np.isfinite(stiffness.data).all()):
        raise InputError("the tufted Laplacian has points without area; remove points on a line")
    return csr_array(stiffness), masses

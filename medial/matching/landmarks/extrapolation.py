"""From landmarks to all points: Eq. 17."""

import numpy as np
from numpy.typing import NDArray

from medial.matching.landmarks.descriptors import DiffusionDescriptors
from medial.matching.nearest import nearest_sum_of_norms, single_blas_thread


def extrapolate_landmarks(
    source: DiffusionDescriptors,
    target: DiffusionDescriptors,
    landmarks: NDArray[np.int64],
    rows: NDArray[np.integer] | slice,
    among: NDArray[np.integer] | None = None,
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Target of some source points by Eq. 17, over all points of the target unless told otherwise.

    Parameters
    ----------
    source, target
    landmarks : (L, 2) int64
        Point ids.
    rows
        Source points to map.
    among
        Target points to choose from; None is all of them.

    Returns
    -------
    index : (rows,) int64
        Target point ids.
    residual : (rows,) float64
        The sum of norms that the target point minimises.
    """
    columns = slice(None) if among is None else among
    with single_blas_thread():
        here = [source.heat(int(p), rows) for p in landmarks[:, 0]] + [source.signatures(rows)]
        there = [target.heat(int(q), columns) for q in landmarks[:, 1]] + [target.signatures(columns)]
    index, residual = nearest_sum_of_norms(here, there)
    return (index if among is None else among[index]).astype(np.int64), residual

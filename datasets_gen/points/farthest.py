"""Farthest-point subsets of clouds of any size."""

import fpsample
import numpy as np
from numpy.typing import NDArray

TREE_HEIGHT = 7
"""Of fpsample's bucket tree on clouds large enough for it; about the fastest for 1e4..1e6 points."""


def farthest_points(points: NDArray[np.float64], n: int, start: int) -> NDArray[np.int64]:
    """Indices of a farthest-point sample, in the order of choice.

    Parameters
    ----------
    points : (m, d)
    n
        Number of points to choose, 1..m.
    start
        Where the choice begins: fpsample counts points in the order of its tree.

    Returns
    -------
    (n,) int64
    """
    height = min(TREE_HEIGHT, int(np.log2(len(points))))
    if height < 1:
        return np.zeros(n, np.int64)  # a single point
    return fpsample.bucket_fps_kdline_sampling(points, n, h=height, start_idx=start).astype(np.int64)

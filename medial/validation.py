"""What a cloud must be before an operator is built on it."""

import logging

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError

log = logging.getLogger(__name__)

FEWEST_POINTS = 8


def check_points(points: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return `points` as (n, 3) float64.

    Raises
    ------
    InputError
        If the array is not (n, 3), has fewer than 8 rows or holds values that are not finite.
    """
    checked: NDArray[np.float64] = np.ascontiguousarray(points, dtype=np.float64)
    if checked.ndim != 2 or checked.shape[1] != 3:
        raise InputError(f"points have shape {checked.shape}; give an (n, 3) array")
    if len(checked) < FEWEST_POINTS:
        raise InputError(f"{len(checked)} points are too few; give at least {FEWEST_POINTS}")
    bad = ~np.isfinite(checked).all(axis=1)
    if bad.any():
        raise InputError(
            f"{bad.sum()} points are not finite, the first is number {bad.argmax()}; remove them"
        )
    return checked


def check_cloud(
    points: NDArray[np.floating], normals: NDArray[np.floating]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return points and unit normals as (n, 3) float64.

    Raises
    ------
    InputError
        If shapes differ, values are not finite or a normal has no length.
    """
    points = check_points(points)
    normals = np.ascontiguousarray(normals, dtype=np.float64)
    if normals.shape != points.shape:
        raise InputError(
            f"normals have shape {normals.shape}, points {points.shape}; give one normal per point"
        )
    lengths = np.linalg.norm(normals, axis=1)
    bad = ~np.isfinite(lengths) | (lengths == 0)
    if bad.any():
        raise InputError(
            f"{bad.sum()} normals are zero or not finite, the first is number {bad.argmax()}; "
            "give unit outward normals, or None to estimate them"
        )
    if np.abs(lengths - 1).max() > 1e-3:
        log.warning("normals are not unit (lengths %.3g to %.3g): normalised", lengths.min(), lengths.max())
    return points, normals / lengths[:, None]

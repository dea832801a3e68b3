"""The ways to a curve skeleton by name."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from datasets_gen.values import did_you_mean
from medial.skeletons.curve_skeleton import CurveSkeleton
from medial.skeletons.local_separators import separator_skeleton
from medial.skeletons.medial_curves import medial_skeleton
from medial.skeletons.rosa import rosa_skeleton

SKELETON_METHODS: dict[str, Callable[..., CurveSkeleton]] = {
    "rosa": rosa_skeleton,
    "medial": medial_skeleton,
    "local-separators": separator_skeleton,
}
"""Functions of points and normals."""


def skeleton_of(
    points: NDArray[np.floating], normals: NDArray[np.floating] | None = None, method: str = "rosa"
) -> CurveSkeleton:
    """The curve skeleton of a cloud.

    Parameters
    ----------
    points : (n, 3)
    normals : (n, 3) or None
        Outward; None estimates them.
    method
        One of `SKELETON_METHODS`.

    Raises
    ------
    InputError
        If there is no such method, its package is missing, or the cloud cannot be used.
    """
    if method not in SKELETON_METHODS:
        hint = did_you_mean(method, SKELETON_METHODS)
        raise InputError(f"unknown skeleton method {method!r}{hint} known are {', '.join(SKELETON_METHODS)}")
    return SKELETON_METHODS[method](points, normals)

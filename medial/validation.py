"""What a cloud must be before an operator is built on it."""

import logging
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.clouds.cleaning import lacking_normals
from datasets_gen.clouds.point_cloud import counted
from datasets_gen.records import InputError
from datasets_gen.values import real_array

log = logging.getLogger(__name__)

FEWEST_POINTS = 8
LARGEST_EXTENT = 1e9
"""Largest side of the box about a cloud; the smallest is one over it."""


@dataclass(frozen=True)
class OrientedCloud:
    """Points and normals that have been checked, and their kd-tree: what every step of an operator reads.

    Attributes
    ----------
    points : (n, 3) float64
    normals : (n, 3) float64
        Unit, outward.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    @cached_property
    def tree(self) -> cKDTree:
        """The points' kd-tree, built on first use."""
        return cKDTree(self.points)


def check_enough(points: int, name: str = "") -> None:
    """Raise InputError, with the name of the cloud if there is one, for too few points."""
    if points < FEWEST_POINTS:
        has = f"{name} has " if name else ""
        raise InputError(f"{has}{counted(points, 'point')}: too few; give at least {FEWEST_POINTS}")


def check_places(points: NDArray[np.float64], name: str) -> None:
    """Raise InputError, with the name of the cloud, if enough points (n, 3) lie at too few places."""
    places = len(np.unique(points, axis=0))
    if places < FEWEST_POINTS <= len(points):
        lie = f"the points of {name} lie at {counted(places, 'place')}"
        raise InputError(f"{lie}: too few; give at least {FEWEST_POINTS} different points")


def check_points(points: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return `points` as (n, 3) float64.

    Raises
    ------
    InputError
        If the array is not (n, 3), has fewer than 8 rows, holds values that are not finite, or has an extent
        that cannot be computed with.
    """
    checked: NDArray[np.float64] = np.ascontiguousarray(real_array(points, "the cloud"))
    if checked.ndim != 2 or checked.shape[1] != 3:
        raise InputError(f"points have shape {checked.shape}; give an (n, 3) array")
    check_enough(len(checked))
    bad = ~np.isfinite(checked).all(axis=1)
    if bad.any():
        raise InputError(
            f"{bad.sum()} points are not finite, the first is number {bad.argmax()}; remove them"
        )
    _check_extent(checked)
    return checked


def _check_extent(points: NDArray[np.float64]) -> None:
    """Raise InputError unless squares and cubes of the cloud's size are numbers in single precision too."""
    extent = float(np.ptp(points, axis=0).max())
    if extent == 0:
        raise InputError(f"all {len(points)} points lie at one place; give a scan of a surface")
    if not 1 / LARGEST_EXTENT <= extent <= LARGEST_EXTENT:
        raise InputError(
            f"the points are {extent:.3g} across; choose units in which it is between "
            f"{1 / LARGEST_EXTENT:.0e} and {LARGEST_EXTENT:.0e}"
        )


def check_directions(normals: NDArray[np.floating], name: str = "the cloud") -> None:
    """Raise InputError if some of (n, 3) normals are zero or not finite; `name` is for the message."""
    bad = lacking_normals(normals)
    if bad.any():
        raise InputError(
            f"{name} has {bad.sum()} normals that are zero or not finite, the first number {bad.argmax()}; "
            "give unit outward normals, or none at all: then they are estimated"
        )


def unit_normals(points: NDArray[np.float64], normals: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the normals of (n, 3) points as (n, 3) float64 of length 1.

    Raises
    ------
    InputError
        If the shapes differ, or a normal is not finite or has no length.
    """
    normals = np.ascontiguousarray(real_array(normals, "the array of normals"))
    if normals.shape != points.shape:
        raise InputError(
            f"normals have shape {normals.shape}, points {points.shape}; give one normal per point"
        )
    check_directions(normals)
    lengths = np.linalg.norm(normals, axis=1)
    if np.abs(lengths - 1).max() > 1e-3:
        log.warning("normals are not unit (lengths %.3g to %.3g): normalised", lengths.min(), lengths.max())
    return normals / lengths[:, None]


def check_cloud(points: NDArray[np.floating], normals: NDArray[np.floating]) -> OrientedCloud:
    """Return points and unit normals as a cloud.

    Raises
    ------
    InputError
        As `check_points` and `unit_normals`.
    """
    points = check_points(points)
    return OrientedCloud(points, unit_normals(points, normals))

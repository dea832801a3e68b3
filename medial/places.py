"""A cloud as the operator sees it: coinciding points merged, normals checked, in kd-tree order."""

import logging
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from medial.outward import check_normals, estimate_normals
from medial.similarity.leaves import kd_order
from medial.validation import OrientedCloud, check_points, unit_normals

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Places:
    """The distinct places of a cloud, and where its points are among them.

    Attributes
    ----------
    cloud : OrientedCloud
        The places, in kd-tree order.
    points, normals : (n, 3) float64
        The given points, and the normal of each one's place.
    index : (n,) int64
        Place of each point.
    copies : (n,) int64
        Points at the same place, itself included.
    """

    cloud: OrientedCloud
    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    index: NDArray[np.int64]
    copies: NDArray[np.int64]


def distinct_places(points: NDArray[np.floating], normals: NDArray[np.floating] | None, modes: int) -> Places:
    """Merge points at the same place, and check or estimate the normals.

    Parameters
    ----------
    points : (n, 3)
    normals : (n, 3) or None
        Outward normals; None estimates them.
    modes
        Eigenpairs that will be asked for: there must be more places.

    Raises
    ------
    InputError
        If the cloud cannot carry an operator.
    """
    given = check_points(points)
    places, which, counts = np.unique(given, axis=0, return_inverse=True, return_counts=True)
    which = which.ravel()
    if len(places) < len(given):
        log.info("%d of %d points coincide with another: merged", len(given) - len(places), len(given))
    check_points(places)
    if modes >= len(places):
        raise InputError(f"{modes} modes asked of {len(places)} points; give fewer modes or more points")
    if normals is None:
        log.warning("normals are missing: estimated from the points and oriented along a spanning tree")
        merged = estimate_normals(places)
    else:
        merged = check_normals(places, _merged_normals(unit_normals(given, normals), which, len(places)))
    order = kd_order(places)
    position = np.empty_like(order)
    position[order] = np.arange(len(order))
    cloud = OrientedCloud(places[order], unit_normals(places[order], merged[order]))
    return Places(cloud, given, merged[which], position[which], counts[which])


def _merged_normals(
    normals: NDArray[np.float64], which: NDArray[np.integer], count: int
) -> NDArray[np.float64]:
    """Mean direction of the normals at every place; the first of them where they cancel."""
    total = np.zeros((count, 3))
    np.add.at(total, which, normals)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    first = np.empty(count, dtype=np.int64)
    first[which[::-1]] = np.arange(len(which))[::-1]
    return np.where(length > 1e-6, total / np.maximum(length, 1e-6), normals[first])

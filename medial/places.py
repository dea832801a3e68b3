"""A cloud as the operator sees it: coinciding points merged, normals checked, in kd-tree order."""

import logging
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.points.strays import nearest_kept, stray_points, words
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
        Points at the same place, itself included; strays not counted.
    stray : (n,) bool
        Points far from all others, which are not among the places; their place is the nearest one.
    """

    cloud: OrientedCloud
    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    index: NDArray[np.int64]
    copies: NDArray[np.int64]
    stray: NDArray[np.bool_]

    def share_of(self, areas: NDArray[np.float64]) -> NDArray[np.float64]:
        """Area of each point, (n,): its share of its place's, and none of a stray."""
        return np.where(self.stray, 0.0, areas[self.index] / self.copies)


def distinct_places(points: NDArray[np.floating], normals: NDArray[np.floating] | None) -> Places:
    """Leave stray points out, merge points at the same place, and check or estimate the normals.

    Parameters
    ----------
    points : (n, 3)
    normals : (n, 3) or None
        Outward normals; None estimates them.

    Raises
    ------
    InputError
        If the cloud cannot carry an operator.
    """
    given = check_points(points)
    unit = None if normals is None else unit_normals(given, normals)
    stray = stray_points(given)
    if stray.any():
        log.warning("%s: left out of scale and areas", words(stray))
    body = given[~stray]
    places, which, counts = np.unique(body, axis=0, return_inverse=True, return_counts=True)
    which = which.ravel()
    if len(places) < len(body):
        log.info("%d of %d points coincide with another: merged", len(body) - len(places), len(body))
    check_points(places)
    if unit is None:
        log.warning("normals are missing: estimated from the points and oriented along a spanning tree")
        merged = estimate_normals(places)
    else:
        merged = check_normals(places, _merged_normals(unit[~stray], which, len(places)))
    order = kd_order(places)
    position = np.empty_like(order)
    position[order] = np.arange(len(order))
    cloud = OrientedCloud(places[order], unit_normals(places[order], merged[order]))
    if stray.any():
        which = which[nearest_kept(given, stray)]
    return Places(cloud, given, merged[which], position[which], counts[which], stray)


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

"""The cloud in kd-tree order, cut into leaves of eight points with bounding sphere and normal cone."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled
from medial.similarity.candidate_ball import columns

LEAF = 8


class SortedCloud(NamedTuple):
    """Points in kd-tree order and their leaves; leaf k holds points 8k to 8k + 8.

    Attributes
    ----------
    x, y, z, u, v, w : (n,) float64
        Positions and normals.
    mass : (n,) float64
        Weight of each point in Eq. 5.
    spheres : (leaves, 4) float64
        Centre and radius of a sphere around each leaf.
    cones : (leaves, 5) float64
        Axis of a cone around each leaf's normals, cosine and sine of its half angle; the cosine is -1 where
        the normals span more than a half space.
    weights : (leaves,) float64
        Sum of `mass`.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    z: NDArray[np.float64]
    u: NDArray[np.float64]
    v: NDArray[np.float64]
    w: NDArray[np.float64]
    mass: NDArray[np.float64]
    spheres: NDArray[np.float64]
    cones: NDArray[np.float64]
    weights: NDArray[np.float64]


def kd_cloud(
    points: NDArray[np.float64], normals: NDArray[np.float64], mass: NDArray[np.float64]
) -> tuple[SortedCloud, NDArray[np.int64]]:
    """Sort a cloud into kd-tree order, which depends on its points alone and not on the caller's order.

    Returns
    -------
    cloud : SortedCloud
    order : (n,) int64
        Place of each sorted point in the caller's arrays.
    """
    canonical = np.lexsort((*normals.T, *points.T))
    order = canonical[kd_order(np.ascontiguousarray(points[canonical]))]
    points, normals, mass = points[order], normals[order], mass[order]
    cones, weights = _normal_cones(normals, mass)
    x, y, z = columns(points)
    u, v, w = columns(normals)
    return SortedCloud(x, y, z, u, v, w, mass, leaf_spheres(points), cones, weights), order


@compiled()
def kd_order(points: Any) -> Any:
    """Order of the points in a left-balanced kd-tree: every leaf but the last is full."""
    n = len(points)
    order = np.arange(n)
    key = np.empty(n)
    stack = np.empty((128, 2), np.int64)
    stack[0, 0], stack[0, 1] = 0, n
    depth = 1
    while depth > 0:
        depth -= 1
        start, stop = stack[depth, 0], stack[depth, 1]
        leaves = (stop - start + LEAF - 1) // LEAF
        if leaves <= 1:
            continue
        axis = _widest(points, order, start, stop)
        for k in range(start, stop):
            key[k] = points[order[k], axis]
        middle = start + LEAF * (leaves // 2)
        _select(key, order, start, stop - 1, middle)
        stack[depth, 0], stack[depth, 1] = middle, stop
        stack[depth + 1, 0], stack[depth + 1, 1] = start, middle
        depth += 2
    return order


@compiled()
def _widest(points: Any, order: Any, start: int, stop: int) -> Any:
    best, widest = 0, -1.0
    for axis in range(3):
        low = high = points[order[start], axis]
        for k in range(start + 1, stop):
            value = points[order[k], axis]
            low, high = min(low, value), max(high, value)
        if high - low > widest:
            best, widest = axis, high - low
    return best


@compiled()
def _select(key: Any, order: Any, low: int, high: int, middle: int) -> None:
    """Reorder so that keys before `middle` are not larger than those after (Hoare's selection)."""
    while low < high:
        pivot = key[(low + high) // 2]
        left, right = low, high
        while left <= right:
            while key[left] < pivot:
                left += 1
            while key[right] > pivot:
                right -= 1
            if left <= right:
                key[left], key[right] = key[right], key[left]
                order[left], order[right] = order[right], order[left]
                left += 1
                right -= 1
        if middle <= right:
            high = right
        elif middle >= left:
            low = left
        else:
            return


@compiled()
def leaf_spheres(points: Any) -> Any:
    """Centre and radius of a sphere around every eight points, (leaves, 4)."""
    n = len(points)
    spheres = np.zeros(((n + LEAF - 1) // LEAF, 4))
    for leaf in range(len(spheres)):
        start, stop = leaf * LEAF, min(leaf * LEAF + LEAF, n)
        for axis in range(3):
            low = high = points[start, axis]
            for k in range(start + 1, stop):
                low, high = min(low, points[k, axis]), max(high, points[k, axis])
            spheres[leaf, axis] = 0.5 * (low + high)
        for k in range(start, stop):
            square = 0.0
            for axis in range(3):
                square += (points[k, axis] - spheres[leaf, axis]) ** 2
            spheres[leaf, 3] = max(spheres[leaf, 3], np.sqrt(square))
    return spheres


@compiled()
def _normal_cones(normals: Any, mass: Any) -> Any:
    """Cone around the normals of every eight points, and their total weight."""
    n = len(normals)
    count = (n + LEAF - 1) // LEAF
    cones, weights = np.zeros((count, 5)), np.zeros(count)
    for leaf in range(count):
        start, stop = leaf * LEAF, min(leaf * LEAF + LEAF, n)
        cone, length, cosine = cones[leaf], 0.0, 1.0
        for axis in range(3):
            for k in range(start, stop):
                cone[axis] += normals[k, axis]
            length += cone[axis] ** 2
        for axis in range(3):
            cone[axis] /= max(np.sqrt(length), 1e-300)
        for k in range(start, stop):
            cosine = min(cosine, normals[k, 0] * cone[0] + normals[k, 1] * cone[1] + normals[k, 2] * cone[2])
            weights[leaf] += mass[k]
        cone[3] = cosine if cosine > 0 else -1.0
        cone[4] = np.sqrt(1.0 - cosine * cosine) if cosine > 0 else 0.0
    return cones, weights

r"""Area of the hull triangles around one point, without building the hull.

The directions u in which a point p is extreme, u.(q - p) <= 0 for all q, form a convex cone. Its extreme
rays are the normals of the hull triangles at p, and each of its faces belongs to the hull edge from p to
one q. The cone is kept as a cyclic list of rays and clipped by one q after the other; if nothing is left, p
lies inside the hull.
"""

from typing import Any

import numpy as np

from datasets_gen.compiled import compiled
from medial.similarity.leaves import LEAF

FLAT = 1e-12  # volumes of unit vectors below this are flat
IN_PLANE = 1e-9
"""Sine of the angle to a plane below which a direction lies in it. What a camera sees in one column of its
pixels lies in one plane with it: the last digits must not decide which of these points are corners."""


@compiled()
def hull_areas(
    points: Any, centers: Any, radii: Any, nearest: Any, spheres: Any, epsilon: float, start: int, stop: int
) -> Any:
    """A third of the hull triangles at each point of leaves [start, stop); NaN where there is no hull.

    Points are in the kd-tree order of their centres; `spheres` bound the leaves of centres, and `nearest`
    holds points that are taken in addition to those whose centres are nearer than `epsilon`.
    """
    n = len(points)
    areas = np.full(min(stop * LEAF, n) - start * LEAF, np.nan)
    near = np.empty(len(spheres), np.int64)
    members = np.empty(n, np.int64)
    offsets, own = np.empty((n, 3)), np.empty(3)
    for leaf in range(start, stop):
        listed = 0
        for other in range(len(spheres)):
            if _square(spheres, leaf, other) <= (spheres[leaf, 3] + spheres[other, 3] + epsilon) ** 2:
                near[listed] = other
                listed += 1
        for i in range(leaf * LEAF, min(leaf * LEAF + LEAF, n)):
            count = 0
            for k in range(listed):
                for j in range(near[k] * LEAF, min(near[k] * LEAF + LEAF, n)):
                    if j != i and _square(centers, i, j) < epsilon * epsilon:
                        members[count] = j
                        count += 1
            for j in nearest[i]:
                if j != i and _square(centers, i, j) >= epsilon * epsilon:
                    members[count] = j
                    count += 1
            for k in range(count):
                for axis in range(3):
                    offsets[k, axis] = points[members[k], axis] - points[i, axis]
            area = fan_area(offsets[:count])
            if np.isnan(area) and count >= 3:
                _put_on_ball(points, i, centers[i], radii[i], own)
                for k in range(count):
                    _put_on_ball(points, members[k], centers[i], radii[i], offsets[k])
                    for axis in range(3):
                        offsets[k, axis] -= own[axis]
                area = fan_area(offsets[:count])
            areas[i - start * LEAF] = area / 3
    return areas


@compiled(inline="always")
def _square(points: Any, i: int, j: int) -> Any:
    dx, dy, dz = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1], points[i, 2] - points[j, 2]
    return dx * dx + dy * dy + dz * dz


@compiled()
def _put_on_ball(points: Any, k: int, center: Any, radius: float, out: Any) -> None:
    x, y, z = points[k, 0] - center[0], points[k, 1] - center[1], points[k, 2] - center[2]
    scale = radius / max(np.sqrt(x * x + y * y + z * z), 1e-300)
    out[0], out[1], out[2] = center[0] + scale * x, center[1] + scale * y, center[2] + scale * z


@compiled()
def _cross(a: Any, b: Any, factor: float, out: Any) -> Any:
    """``factor * a x b`` into `out`; its squared length."""
    x, y, z = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    out[0], out[1], out[2] = factor * x, factor * y, factor * z
    return factor * factor * (x * x + y * y + z * z)


@compiled()
def _dot(a: Any, b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled()
def fan_area(offsets: Any) -> Any:
    """Area of the hull triangles at the origin, of the origin and some points; NaN if it is not a corner.

    Parameters
    ----------
    offsets : (m, 3) float64
        The other points, relative to the one in question; coinciding ones are ignored.
    """
    count = len(offsets)
    if count < 3:
        return np.nan
    units = np.empty((count, 3))
    for k in range(count):
        length = max(np.sqrt(_dot(offsets[k], offsets[k])), 1e-300)
        for axis in range(3):
            units[k, axis] = offsets[k, axis] / length
    normal = np.empty(3)
    first, second, third, volume = _spanning(units, normal)
    if abs(volume) < FLAT:
        return np.nan
    rays, fresh = np.empty((count + 3, 3)), np.empty((count + 3, 3))
    edges, labels = np.empty(count + 3, np.int64), np.empty(count + 3, np.int64)
    sides = np.empty(count + 3)
    flip = -1.0 if volume > 0 else 1.0
    edges[0], edges[1], edges[2] = first, second, third
    for m in range(3):  # ray m lies between faces edges[m - 1] and edges[m]
        _cross(units[edges[m - 1 if m > 0 else 2]], units[edges[m]], flip, rays[m])
    sizes = 3
    for k in range(count):
        if k in (first, second, third):
            continue
        cut, left = False, 0
        for m in range(sizes):
            side = _dot(rays[m], units[k])
            sides[m] = 0.0 if abs(side) < IN_PLANE else side
            cut = cut or sides[m] > 0.0
            left += sides[m] <= 0.0
        if not cut:
            continue
        if left == 0:
            return np.nan
        sizes = _clip(rays, edges, sides, sizes, k, fresh, labels)
        rays, fresh, edges, labels = fresh, rays, labels, edges
    if sizes < 3:
        return np.nan  # within a face or an edge
    total = 0.0
    for m in range(sizes):
        total += np.sqrt(
            _cross(offsets[edges[m - 1 if m > 0 else sizes - 1]], offsets[edges[m]], 1.0, normal)
        )
    return 0.5 * total


@compiled()
def _spanning(units: Any, normal: Any) -> Any:
    """Three directions that span a large volume, and that volume."""
    first = 0
    while first + 1 < len(units) and _dot(units[first], units[first]) == 0.0:
        first += 1
    second, widest = first, 0.0
    for k in range(len(units)):
        square = _cross(units[first], units[k], 1.0, normal)
        if square > widest:
            second, widest = k, square
    third, volume = first, 0.0
    _cross(units[first], units[second], 1.0, normal)
    for k in range(len(units)):
        side = _dot(normal, units[k])
        if abs(side) > abs(volume):
            third, volume = k, side
    return first, second, third, volume


@compiled()
def _clip(rays: Any, edges: Any, sides: Any, sizes: int, face: int, fresh: Any, labels: Any) -> Any:
    """Keep the part of a cone with side <= 0; the new face is labelled `face`."""
    kept = 0
    for m in range(sizes):
        after = m + 1 if m + 1 < sizes else 0
        if sides[m] <= 0.0:
            for axis in range(3):
                fresh[kept, axis] = rays[m, axis]
            labels[kept] = face if sides[m] == 0.0 and sides[after] > 0.0 else edges[m]
            kept += 1
        if sides[m] * sides[after] < 0.0:  # a new ray where the edge between two rays is cut
            for axis in range(3):
                fresh[kept, axis] = sides[after] * rays[m, axis] - sides[m] * rays[after, axis]
            scale = np.sqrt(_dot(fresh[kept], fresh[kept])) * (1.0 if sides[m] < 0.0 else -1.0)
            for axis in range(3):
                fresh[kept, axis] /= scale
            labels[kept] = face if sides[m] < 0.0 else edges[m]
            kept += 1
    return kept

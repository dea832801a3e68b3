r"""Area of the hull triangles around one point, without building the hull.

The directions u in which a point p is extreme, u.(q - p) <= 0 for all q, form a convex cone. Its extreme rays are
the normals of the hull triangles at p, and each of its faces belongs to the hull edge from p to one q. The cone is
kept as a cyclic list of rays and clipped by one q after the other; if nothing is left, p lies inside the hull.
"""

from typing import Any

import numpy as np

from medial.compiled import compiled
from medial.similarity_tree import LEAF

FLAT = 1e-12  # volumes of unit vectors below this are flat


@compiled()
def hull_areas(
    points: Any, centers: Any, radii: Any, spheres: Any, epsilon: float, start: int, stop: int
) -> Any:
    """A third of the hull triangles at each point of leaves [start, stop); NaN where there is no hull.

    Points are in the kd-tree order of their centres; `spheres` bound the leaves of centres.
    """
    n = len(points)
    areas = np.full(min(stop * LEAF, n) - start * LEAF, np.nan)
    near = np.empty(len(spheres), np.int64)
    members = np.empty(n, np.int64)
    offsets = np.empty((n, 3))
    for leaf in range(start, stop):
        listed = 0
        for other in range(len(spheres)):
            reach = spheres[leaf, 3] + spheres[other, 3] + epsilon
            if ((spheres[leaf, :3] - spheres[other, :3]) ** 2).sum() <= reach * reach:
                near[listed] = other
                listed += 1
        for i in range(leaf * LEAF, min(leaf * LEAF + LEAF, n)):
            count = 0
            for k in range(listed):
                for j in range(near[k] * LEAF, min(near[k] * LEAF + LEAF, n)):
                    dx, dy, dz = centers[i, 0] - centers[j, 0], centers[i, 1] - centers[j, 1], centers[i, 2] - centers[j, 2]
                    if j != i and dx * dx + dy * dy + dz * dz < epsilon * epsilon:
                        members[count] = j
                        count += 1
            for k in range(count):
                for axis in range(3):
                    offsets[k, axis] = points[members[k], axis] - points[i, axis]
            area = fan_area(offsets[:count])
            if np.isnan(area) and count >= 3:
                own = _on_ball(points[i], centers[i], radii[i])
                for k in range(count):
                    offsets[k] = _on_ball(points[members[k]], centers[i], radii[i]) - own
                area = fan_area(offsets[:count])
            areas[i - start * LEAF] = area / 3
    return areas


@compiled()
def _on_ball(point: Any, center: Any, radius: float) -> Any:
    offset = point - center
    length = np.sqrt((offset * offset).sum())
    return center + radius * offset / max(length, 1e-300)


@compiled()
def fan_area(offsets: Any) -> Any:
    """Area of the hull triangles at the origin, of the origin and some points; NaN if it is not a corner.

    Parameters
    ----------
    offsets : (m, 3) float64
        The other points, relative to the one in question; coinciding ones are ignored.
    """
    count = len(offsets)
    units = np.empty((count, 3))
    for k in range(count):
        length = np.sqrt((offsets[k] * offsets[k]).sum())
        units[k] = offsets[k] / max(length, 1e-300)
    first, second, third, volume = _spanning(units)
    if abs(volume) < FLAT:
        return np.nan
    rays, fresh = np.empty((count + 3, 3)), np.empty((count + 3, 3))
    edges, labels = np.empty(count + 3, np.int64), np.empty(count + 3, np.int64)
    sides = np.empty(count + 3)
    flip = -1.0 if volume > 0 else 1.0
    # ray k lies between faces edges[k - 1] and edges[k]
    rays[0], edges[0] = flip * np.cross(units[third], units[first]), first
    rays[1], edges[1] = flip * np.cross(units[first], units[second]), second
    rays[2], edges[2] = flip * np.cross(units[second], units[third]), third
    sizes = 3
    for k in range(count):
        if k == first or k == second or k == third:
            continue
        cut, left = False, 0
        for m in range(sizes):
            sides[m] = rays[m, 0] * units[k, 0] + rays[m, 1] * units[k, 1] + rays[m, 2] * units[k, 2]
            cut = cut or sides[m] > 0.0
            left += sides[m] <= 0.0
        if not cut:
            continue
        if left == 0:
            return np.nan
        sizes = _clip(rays, edges, sides, sizes, k, fresh, labels)
        rays, fresh, edges, labels = fresh, rays, labels, edges
    total = 0.0
    for m in range(sizes):
        a, b = offsets[edges[m - 1 if m > 0 else sizes - 1]], offsets[edges[m]]
        normal = np.cross(a, b)
        total += 0.5 * np.sqrt((normal * normal).sum())
    return total


@compiled()
def _spanning(units: Any) -> Any:
    """Three directions that span a large volume, and that volume."""
    first = 0
    for k in range(len(units)):
        if (units[k] * units[k]).sum() > 0:
            first = k
            break
    second, widest = first, 0.0
    for k in range(len(units)):
        normal = np.cross(units[first], units[k])
        if (normal * normal).sum() > widest:
            second, widest = k, (normal * normal).sum()
    third, volume = first, 0.0
    if widest > 0:
        normal = np.cross(units[first], units[second])
        for k in range(len(units)):
            side = (normal * units[k]).sum()
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
            fresh[kept], labels[kept] = rays[m], edges[m]
            kept += 1
            if sides[after] > 0.0 and sides[m] < 0.0:
                fresh[kept] = sides[after] * rays[m] - sides[m] * rays[after]
                fresh[kept] /= np.sqrt((fresh[kept] * fresh[kept]).sum())
                labels[kept] = face
                kept += 1
            elif sides[after] > 0.0:
                labels[kept - 1] = face
        elif sides[after] < 0.0:
            fresh[kept] = sides[m] * rays[after] - sides[after] * rays[m]
            fresh[kept] /= np.sqrt((fresh[kept] * fresh[kept]).sum())
            labels[kept] = edges[m]
            kept += 1
    return kept

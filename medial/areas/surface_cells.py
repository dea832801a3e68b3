"""Local surface area of every point: its Voronoi cell in the tangent plane."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled, ranges, run_tasks
from datasets_gen.points.neighbours import query_tree
from medial.validation import OrientedCloud, check_cloud

NEIGHBOURS = 24
RING = 6  # neighbours whose mean distance bounds the cell ...
REACH = 0.8  # ... times this
SIDES = 16
LARGEST_CELL = 1.5  # in the median reach of the neighbours: an outlier stands for little
REFERENCE_POINTS = 17_500  # middle of the paper's 15,000-20,000
ROWS_PER_TASK = 2048


def surface_areas(points: NDArray[np.floating], normals: NDArray[np.floating]) -> NDArray[np.float64]:
    """Area of every point's Voronoi cell among its neighbours projected to its tangent plane [BSW09].

    Neighbours whose normals point the other way lie on another sheet and do not count. A cell reaches at most
    0.8 times the mean distance of the six nearest neighbours, and 1.5 times the median of that over the
    neighbourhood: this closes the cells of points at the rim of a hole, and of stray points.

    Parameters
    ----------
    points, normals : (n, 3)

    Returns
    -------
    (n,) float64, in squared units
    """
    return surface_cells(check_cloud(points, normals))


def surface_cells(cloud: OrientedCloud) -> NDArray[np.float64]:
    """`surface_areas` of a cloud that has been checked."""
    points, normals = cloud.points, cloud.normals
    count = min(NEIGHBOURS + 1, len(points))
    distances, neighbours = query_tree(cloud.tree, points, k=count)
    reach = REACH * _ring_distances(normals, distances, neighbours)
    reach = np.minimum(reach, LARGEST_CELL * np.median(reach[neighbours[:, 1:]], axis=1))
    tasks = [(points, normals, neighbours, reach, *span) for span in ranges(len(points), ROWS_PER_TASK)]
    return np.concatenate(run_tasks(_cells, tasks))


def density_weights(
    areas: NDArray[np.floating], reference_points: float = REFERENCE_POINTS
) -> NDArray[np.float64]:
    r"""Weight of each point in Eq. 5 that makes gamma independent of how many points were taken, and where.

    Eq. 5 sums over points, so it estimates rho \int mu dA with the density rho of the cloud, and sigma_e = 5
    belongs to the paper's 15,000-20,000 points. A point that stands for the area a counts
    ``reference_points * a / A``, with the sum A of all areas: the sum then estimates the same integral at the
    paper's density.

    Parameters
    ----------
    areas : (n,)
        Surface area each point stands for (`surface_areas`).
    reference_points
        Points the paper's clouds have.

    Returns
    -------
    (n,) float64
    """
    return np.asarray(areas, dtype=np.float64) * (reference_points / float(np.sum(areas)))


@compiled()
def _ring_distances(normals: Any, distances: Any, neighbours: Any) -> Any:
    """Mean distance of the six nearest neighbours on the same sheet; on any sheet where there are none."""
    means = np.zeros(len(normals))
    for i in range(len(normals)):
        count, other = 0, 0.0
        for k in range(1, neighbours.shape[1]):
            j = neighbours[i, k]
            agree = (
                normals[i, 0] * normals[j, 0] + normals[i, 1] * normals[j, 1] + normals[i, 2] * normals[j, 2]
            )
            if agree > 0 and count < RING:
                means[i] += distances[i, k]
                count += 1
            if k <= RING:
                other += distances[i, k] / RING
        means[i] = means[i] / count if count > 0 else other
    return means


@compiled()
def _clip(polygon: Any, count: int, x: float, y: float, limit: float, out: Any) -> Any:
    """Keep the part of a convex polygon with (x, y).v <= limit; corners into `out`, their number returned."""
    kept = 0
    for k in range(count):
        ax, ay = polygon[k, 0], polygon[k, 1]
        nxt = k + 1 if k + 1 < count else 0
        bx, by = polygon[nxt, 0], polygon[nxt, 1]
        a, b = ax * x + ay * y - limit, bx * x + by * y - limit
        if a <= 0:
            out[kept, 0], out[kept, 1] = ax, ay
            kept += 1
        if (a < 0 < b) or (b < 0 < a):
            s = a / (a - b)
            out[kept, 0], out[kept, 1] = ax + s * (bx - ax), ay + s * (by - ay)
            kept += 1
    return kept


@compiled()
def _cells(points: Any, normals: Any, neighbours: Any, reach: Any, start: int, stop: int) -> Any:
    """Areas of the cells of points [start, stop)."""
    areas = np.zeros(stop - start)
    polygon = np.empty((SIDES + neighbours.shape[1] + 2, 2))
    other = np.empty_like(polygon)
    for i in range(start, stop):
        a, b, c = normals[i, 0], normals[i, 1], normals[i, 2]
        # two axes of the tangent plane [Duff et al. 2017]
        sign = 1.0 if c >= 0 else -1.0
        p = -1.0 / (sign + c)
        q = a * b * p
        ux, uy, uz, vx, vy, vz = 1 + sign * a * a * p, sign * q, -sign * a, q, sign + b * b * p, -b
        count = SIDES
        j = neighbours[i, 1]  # the polygon turns with the cloud
        dx, dy, dz = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
        turn = np.arctan2(dx * vx + dy * vy + dz * vz, dx * ux + dy * uy + dz * uz)
        for k in range(SIDES):
            polygon[k, 0] = reach[i] * np.cos(turn + 2 * np.pi * k / SIDES)
            polygon[k, 1] = reach[i] * np.sin(turn + 2 * np.pi * k / SIDES)
        for k in range(1, neighbours.shape[1]):
            j = neighbours[i, k]
            if j == i or normals[j, 0] * a + normals[j, 1] * b + normals[j, 2] * c <= 0:
                continue
            dx, dy, dz = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
            x, y = dx * ux + dy * uy + dz * uz, dx * vx + dy * vy + dz * vz
            if x * x + y * y == 0:
                continue
            count = _clip(polygon, count, x, y, 0.5 * (x * x + y * y), other)
            polygon, other = other, polygon
        for k in range(count):
            after = k + 1 if k + 1 < count else 0
            cross = polygon[k, 0] * polygon[after, 1] - polygon[after, 0] * polygon[k, 1]
            areas[i - start] += 0.5 * cross
    return areas

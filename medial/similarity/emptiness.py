"""Emptiness of candidate balls (Eqs. 5-7), one cell of centres at a time.

Balls centred in one cell share their neighbourhood: the points in reach are gathered once, in order of
distance from the cell's centre. All balls of the cell then sum their depths side by side (SIMD over balls,
not over points), nearest points first; between growing chunks of points, balls whose similarity fell below
the cut-off are dropped.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled, run_tasks
from medial.similarity.candidate_ball import candidate_ball
from medial.similarity.candidate_pairs import Pairs
from medial.similarity.critical_radius import Grid
from medial.similarity.leaves import LEAF, SortedCloud

CHUNK = 32  # points in the first chunk; every chunk doubles
RINGS = 64  # bins of distance from the cell's centre
PAIRS_PER_TASK = 2**16


class Settings(NamedTuple):
    """Parameters of Eq. 7 and of its truncation: ln(1 / cut-off), radius cap and cut-off."""

    sigma_e: float
    sigma_t: float
    budget: float
    cap: float
    cutoff: float


class _Balls(NamedTuple):
    """Balls of one cell, relative to its centre: inverse squared radius, largest depth, depth so far, ..."""

    x: NDArray[np.float32]
    y: NDArray[np.float32]
    z: NDArray[np.float32]
    inverse: NDArray[np.float32]
    most: NDArray[np.float32]
    depth: NDArray[np.float32]
    tilt: NDArray[np.float64]
    outer: NDArray[np.float64]
    pair: NDArray[np.int64]


def similarities(cloud: SortedCloud, grid: Grid, pairs: Pairs, settings: Settings) -> NDArray[np.float64]:
    """Phi of every candidate pair; 0 where it is below the cut-off.

    Returns
    -------
    (pairs,) float64
    """
    values = np.zeros(len(pairs.i))
    marks = np.arange(0, len(values), PAIRS_PER_TASK)
    cuts = np.unique(np.append(np.searchsorted(pairs.starts, marks, side="right") - 1, len(grid.cells)))
    arrays = (cloud, grid.cells, pairs, settings, values)
    run_tasks(_cells, [(*arrays, a, b) for a, b in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True)])
    return values


@compiled()
def _cells(cloud: Any, cells: Any, pairs: Any, settings: Any, values: Any, start: int, stop: int) -> None:
    """Phi of the pairs of cells [start, stop) into `values`."""
    n, total = len(cloud.x), len(cloud.spheres)
    gathered, near = np.empty((n, 5)), np.empty((n + CHUNK, 4), np.float32)
    leaves = np.empty(total + 1, np.int64)
    listed, held, held_at = 0, -1.0, np.zeros(3)
    room = 0
    for cell in range(start, stop):
        room = max(room, pairs.starts[cell + 1] - pairs.starts[cell])
    balls = _Balls(
        np.empty(room, np.float32), np.empty(room, np.float32), np.empty(room, np.float32),
        np.empty(room, np.float32), np.empty(room, np.float32), np.empty(room, np.float32),
        np.empty(room), np.empty(room), np.empty(room, np.int64),
    )  # fmt: skip
    for cell in range(start, stop):
        center = cells[cell, 1:4]
        count, reach = _take_balls(
            cloud, pairs, center, pairs.starts[cell], pairs.starts[cell + 1], settings, balls
        )
        if count == 0:
            continue
        dx, dy, dz = center[0] - held_at[0], center[1] - held_at[1], center[2] - held_at[2]
        if np.sqrt(dx * dx + dy * dy + dz * dz) + reach > held:
            held, held_at = 1.5 * reach, center  # neighbouring cells share one list of leaves
            listed = _leaves_within(cloud.spheres, center, held, leaves)
        ends, nearest, scale = _gather(cloud, leaves[:listed], center, reach, gathered, near)
        count = _sum_depths(balls, count, reach, near, ends, nearest, scale)
        for k in range(count):
            gamma = balls.depth[k] / settings.sigma_e
            values[balls.pair[k]] = np.exp(-gamma * gamma - balls.tilt[k])


@compiled()
def _take_balls(
    cloud: Any, pairs: Any, center: Any, start: int, stop: int, settings: Any, balls: Any
) -> tuple[int, float]:
    """Candidate balls of pairs [start, stop), in double precision; their number, and how far they reach."""
    count, reach = 0, 0.0
    for k in range(start, stop):
        x, y, z, r, tangency = candidate_ball(
            cloud.x, cloud.y, cloud.z, cloud.u, cloud.v, cloud.w, pairs.i[k], pairs.j[k]
        )
        tilt = (
            4.0 * max(2.0 - tangency, 0.0) / (settings.sigma_t * settings.sigma_t)
        )  # (tau / sigma_t)^2, Eq. 4
        if r <= 0.0 or r > settings.cap or tilt >= settings.budget:
            continue
        x, y, z = x - center[0], y - center[1], z - center[2]
        balls.x[count], balls.y[count], balls.z[count], balls.inverse[count] = x, y, z, 1.0 / (r * r)
        balls.tilt[count], balls.pair[count], balls.depth[count] = tilt, k, 0.0
        balls.most[count] = settings.sigma_e * np.sqrt(settings.budget - tilt)
        balls.outer[count] = r + np.sqrt(x * x + y * y + z * z)
        reach = max(reach, balls.outer[count])
        count += 1
    return count, reach


@compiled()
def _leaves_within(spheres: Any, center: Any, reach: float, leaves: Any) -> Any:
    count = 0
    for leaf in range(len(spheres)):
        dx, dy, dz = spheres[leaf, 0] - center[0], spheres[leaf, 1] - center[1], spheres[leaf, 2] - center[2]
        far = reach + spheres[leaf, 3]
        leaves[count] = leaf
        count += dx * dx + dy * dy + dz * dz <= far * far
    return count


@compiled()
def _gather(cloud: Any, leaves: Any, center: Any, reach: float, gathered: Any, near: Any) -> Any:
    """Points at most `reach` from `center`, relative to it, ring by ring; ends and scale of the rings."""
    found, nearest = 0, reach
    for leaf in leaves:
        sphere = cloud.spheres[leaf]
        dx, dy, dz = sphere[0] - center[0], sphere[1] - center[1], sphere[2] - center[2]
        if dx * dx + dy * dy + dz * dz > (reach + sphere[3]) ** 2:
            continue
        for m in range(leaf * LEAF, min(leaf * LEAF + LEAF, len(cloud.x))):
            dx, dy, dz = cloud.x[m] - center[0], cloud.y[m] - center[1], cloud.z[m] - center[2]
            distance = np.sqrt(dx * dx + dy * dy + dz * dz)
            if distance <= reach:
                gathered[found, 0], gathered[found, 1], gathered[found, 2] = dx, dy, dz
                gathered[found, 3], gathered[found, 4] = cloud.mass[m], distance
                nearest = min(nearest, distance)
                found += 1
    scale = (RINGS - 1e-3) / max(reach - nearest, 1e-300)
    ends = np.zeros(RINGS + 1, np.int64)
    for k in range(found):
        ends[int((gathered[k, 4] - nearest) * scale) + 1] += 1
    for ring in range(RINGS):
        ends[ring + 1] += ends[ring]
    place = ends[:-1].copy()
    for k in range(found):
        ring = int((gathered[k, 4] - nearest) * scale)
        for axis in range(4):
            near[place[ring], axis] = gathered[k, axis]
        place[ring] += 1
    near[found : found + CHUNK] = 0.0  # weightless padding to whole chunks
    return ends, nearest, scale


@compiled()
def _sum_depths(
    balls: Any, count: int, reach: float, near: Any, ends: Any, nearest: float, scale: float
) -> Any:
    """Sum the depths of balls [0, count), dropping those too full; the number left, moved to the front."""
    first, size = 0, CHUNK
    while count > 0:
        end = ends[min(max(int((reach - nearest) * scale), 0), RINGS - 1) + 1]
        last = (min(end, first + size) + 3) // 4 * 4
        if first < last:
            b = balls
            _add(near, first, last, b.x[:count], b.y[:count], b.z[:count], b.inverse[:count], b.depth[:count])
        kept, reach = 0, 0.0
        for k in range(count):
            if balls.depth[k] <= balls.most[k]:
                balls.x[kept], balls.y[kept], balls.z[kept] = balls.x[k], balls.y[k], balls.z[k]
                balls.inverse[kept], balls.most[kept] = balls.inverse[k], balls.most[k]
                balls.depth[kept] = balls.depth[k]
                balls.tilt[kept], balls.outer[kept], balls.pair[kept] = (
                    balls.tilt[k],
                    balls.outer[k],
                    balls.pair[k],
                )
                reach = max(reach, balls.outer[kept])
                kept += 1
        count = kept
        if last >= end:
            break
        first, size = last, 2 * size
    return count


@compiled()
def _add(near: Any, first: int, last: int, cx: Any, cy: Any, cz: Any, inverse: Any, depth: Any) -> None:
    """Add mass (1 - (|p - c| / r)^4)_+ (Eq. 6) of points [first, last) to every depth, four at a time."""
    one, zero = np.float32(1), np.float32(0)
    for m in range(first, last, 4):
        x0, y0, z0, w0 = near[m, 0], near[m, 1], near[m, 2], near[m, 3]
        x1, y1, z1, w1 = near[m + 1, 0], near[m + 1, 1], near[m + 1, 2], near[m + 1, 3]
        x2, y2, z2, w2 = near[m + 2, 0], near[m + 2, 1], near[m + 2, 2], near[m + 2, 3]
        x3, y3, z3, w3 = near[m + 3, 0], near[m + 3, 1], near[m + 3, 2], near[m + 3, 3]
        for k in range(len(depth)):
            x, y, z, scale = cx[k], cy[k], cz[k], inverse[k]
            q0 = ((x - x0) * (x - x0) + (y - y0) * (y - y0) + (z - z0) * (z - z0)) * scale
            q1 = ((x - x1) * (x - x1) + (y - y1) * (y - y1) + (z - z1) * (z - z1)) * scale
            q2 = ((x - x2) * (x - x2) + (y - y2) * (y - y2) + (z - z2) * (z - z2)) * scale
            q3 = ((x - x3) * (x - x3) + (y - y3) * (y - y3) + (z - z3) * (z - z3)) * scale
            low = w0 * max(one - q0 * q0, zero) + w1 * max(one - q1 * q1, zero)
            depth[k] += low + (w2 * max(one - q2 * q2, zero) + w3 * max(one - q3 * q3, zero))

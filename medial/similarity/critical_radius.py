r"""The critical-radius grid: how large a nearly empty ball centred in a cell can be.

A ball of radius rho around any point of a cell holds every point of a leaf at most t away from its centre,
where t is the distance between the centres of cell and leaf, plus the leaf's radius, plus half the cell's
diagonal. So its gamma (Eq. 5) is at least \sum_leaves w (1 - (t / rho)^4)_+. The critical radius is the rho
at which that sum reaches the largest gamma the cut-off lets through; no larger ball centred in the cell can
pass. In s = rho^-4 the sum is convex and decreasing, so Newton's method from the left never oversteps: every
iterate is a valid bound.

A cell is dead if no point at a distance up to rho faces away from it, as no ball centred there can then be
tangent to anything. Cells are refined octree-fashion until they are small against their critical radius;
inside the cloud's bounding box they become four times finer than outside. Dead cells are not refined.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled, grown, run_tasks
from medial.similarity.leaves import SortedCloud

FINE = 4  # fine cells along a coarse one
ROOT = 8  # coarse cells along a root
LEVELS = 6  # log2(FINE * ROOT) + 1
CELL = 1.8  # width of a fine cell in typical leaf radii
MOST_CELLS = 2**18  # fine cells: their table should stay in the processor's cache
MOST_COARSE = 128  # coarse cells along an axis
FINENESS = 0.25  # cells are not refined when their half diagonal is below this share of the critical radius
NEWTON_STEPS = 8


class Grid(NamedTuple):
    """Critical radii over a box: a coarse table of all of it and a fine table of its inner part.

    Attributes
    ----------
    origin : (3,) float64
        Lowest corner of the coarse table.
    size : float
        Width of the fine cells; coarse ones are `FINE` times as wide.
    coarse : (3,) int64
        Coarse cells along each axis.
    inner : (2, 3) int64
        First and last + 1 coarse cell that the fine table covers.
    table : (1 + fine + coarse,) int32
        Cell that covers each entry of the fine table, then of the coarse table; entry 0 is dead.
    cells : (1 + live, 4) float64
        Critical radius and centre of the live cells; cell 0 is dead.
    """

    origin: NDArray[np.float64]
    size: float
    coarse: NDArray[np.int64]
    inner: NDArray[np.int64]
    table: NDArray[np.int32]
    cells: NDArray[np.float64]


class _Limits(NamedTuple):
    """What every task of the refinement reads."""

    origin: NDArray[np.float64]
    size: float
    roots: NDArray[np.int64]
    inner: NDArray[np.int64]
    most: float
    tangency: float
    cap: float


def critical_grid(cloud: SortedCloud, most: float, tangency: float, cap: float) -> Grid:
    """Build the grid.

    Parameters
    ----------
    cloud
        Points and leaves.
    most
        Largest gamma that can pass the cut-off.
    tangency
        Smallest F that can pass; the ball's normal and the point's then enclose at most acos(F / 2).
    cap
        Largest radius, positive.
    """
    axes = np.stack([cloud.x, cloud.y, cloud.z])
    low, extent = axes.min(axis=1), np.ptp(axes, axis=1)
    size = CELL * float(np.median(cloud.spheres[:, 3]))
    size = max(size, float(np.prod((extent + size) / MOST_CELLS ** (1 / 3)) ** (1 / 3)))
    size = max(size, float(extent.max() + 2 * cap) / (FINE * MOST_COARSE))
    wide = FINE * size
    inside = np.floor(extent / wide).astype(np.int64) + 1
    before = int(np.ceil(cap / wide))
    inner = np.stack([np.full(3, before), before + inside])
    coarse = inside + 2 * before
    roots = -(-coarse // ROOT)
    limits = _Limits(low - before * wide, size, roots, inner, most, tangency, cap)
    parts = run_tasks(_refine_root, [(cloud, limits, root) for root in range(int(roots.prod()))])
    cells = np.concatenate([np.zeros(4), *(part[0] for part in parts)]).reshape(-1, 4)
    places = np.concatenate([np.zeros(4, np.int64), *(part[1] for part in parts)]).reshape(-1, 4)
    return Grid(limits.origin, size, coarse, inner, _tables(places, coarse, inner), cells)


@compiled()
def _tables(places: Any, coarse: Any, inner: Any) -> Any:
    """Both tables, from the level and place of every live cell."""
    fine = (inner[1] - inner[0]) * FINE
    first = 1 + fine[0] * fine[1] * fine[2]
    table = np.zeros(first + coarse[0] * coarse[1] * coarse[2], np.int32)
    for cell in range(1, len(places)):
        span = 2 ** (LEVELS - places[cell, 0])
        x, y, z = places[cell, 1] * span, places[cell, 2] * span, places[cell, 3] * span
        x0, y0, z0 = inner[0, 0] * FINE, inner[0, 1] * FINE, inner[0, 2] * FINE
        _fill_box(table, 1, fine, x - x0, y - y0, z - z0, span, cell)
        if span >= FINE:
            _fill_box(table, first, coarse, x // FINE, y // FINE, z // FINE, span // FINE, cell)
    return table


@compiled()
def _fill_box(table: Any, first: int, counts: Any, x: int, y: int, z: int, span: int, cell: int) -> None:
    """Write `cell` into the part of a cube of entries that lies inside a table starting at `first`."""
    for i in range(max(x, 0), min(x + span, counts[0])):
        for j in range(max(y, 0), min(y + span, counts[1])):
            row = first + (i * counts[1] + j) * counts[2]
            for k in range(max(z, 0), min(z + span, counts[2])):
                table[row + k] = cell


@compiled()
def _refine_root(cloud: Any, limits: Any, root: int) -> Any:
    """The live cells of one root: critical radius and centre, level and place of each."""
    total = len(cloud.spheres)
    lists, lengths = np.empty((LEVELS + 1, total), np.int32), np.zeros(LEVELS + 1, np.int64)
    for leaf in range(total):  # leaves in reach, by level: a cell looks at its parent's
        lists[0, leaf] = leaf
    lengths[0] = total
    place, center = np.empty(4, np.int64), np.empty(3)
    scratch = np.empty((3, total), np.float32)
    stack, bounds = np.empty((8 * LEVELS, 4), np.int64), np.empty(8 * LEVELS)
    cells, places = np.empty(256), np.empty(256, np.int64)  # four values each
    roots = limits.roots
    stack[0, 0], stack[0, 1] = 1, root // (roots[1] * roots[2])
    stack[0, 2], stack[0, 3] = root // roots[2] % roots[1], root % roots[2]
    bounds[0] = limits.cap
    depth, found = 1, 0
    while depth > 0:
        depth -= 1
        level = stack[depth, 0]
        width = limits.size * 2 ** (LEVELS - level)
        half = 0.8661 * width
        for k in range(4):
            place[k] = stack[depth, k]
        for axis in range(3):
            center[axis] = limits.origin[axis] + (place[1 + axis] + 0.5) * width
        rho = _critical_radius(
            cloud, center, half, bounds[depth], limits.most, lists, lengths, level, scratch
        )
        if not _alive(cloud, center, half, rho, limits.tangency, lists, lengths, level, scratch):
            continue
        if half < FINENESS * rho or _finest(place, limits.inner):
            if found == len(cells):
                cells, places = grown(cells), grown(places)
            cells[found], cells[found + 1], cells[found + 2], cells[found + 3] = (
                rho,
                center[0],
                center[1],
                center[2],
            )
            for k in range(4):
                places[found + k] = place[k]
            found += 4
            continue
        for child in range(8):
            stack[depth, 0], stack[depth, 1] = level + 1, 2 * place[1] + (child & 1)
            stack[depth, 2], stack[depth, 3] = 2 * place[2] + (child >> 1 & 1), 2 * place[3] + (child >> 2)
            bounds[depth] = rho
            depth += 1
    return cells[:found].copy(), places[:found].copy()


@compiled()
def _finest(place: Any, inner: Any) -> Any:
    """Whether a cell is as fine as its part of the box allows."""
    span = FINE * ROOT >> (place[0] - 1)  # width in fine cells
    if span > FINE or span == 1:
        return span == 1
    for axis in range(3):
        start = place[1 + axis] * span
        if start + span <= inner[0, axis] * FINE or start >= inner[1, axis] * FINE:
            return True
    return False


@compiled()
def _critical_radius(
    cloud: Any,
    center: Any,
    half: float,
    bound: float,
    most: float,
    lists: Any,
    lengths: Any,
    level: int,
    scratch: Any,
) -> Any:
    """Critical radius of a cell, at most its parent's `bound`; leaves in reach into the level's list."""
    parents, mine, away = lists[level - 1], lists[level], scratch[2]
    kept, within = 0, 0
    for k in range(lengths[level - 1]):
        sphere = cloud.spheres[parents[k]]
        dx, dy, dz = sphere[0] - center[0], sphere[1] - center[1], sphere[2] - center[2]
        distance = np.sqrt(dx * dx + dy * dy + dz * dz)
        spread = sphere[3] + half
        if distance - spread > bound:
            continue
        mine[kept], away[kept] = parents[k], distance
        kept += 1
        if distance + spread < bound:
            scratch[0, within] = (distance + spread) ** 4 / bound**4  # in units of the bound: no overflow
            scratch[1, within] = cloud.weights[parents[k]]
            within += 1
    lengths[level] = kept
    return 1.0001 * bound * _newton(scratch[0, :within], scratch[1, :within], np.float32(most)) ** -0.25


@compiled()
def _newton(fourth: Any, weight: Any, most: Any) -> Any:
    """The s >= 1 at which the sum of weight (1 - fourth s)_+ falls to `most`, from the left of it."""
    one, none = np.float32(1), np.float32(0)
    s = one
    for _ in range(NEWTON_STEPS):
        constant, slope = none, none
        for k in range(len(fourth)):
            inside = weight[k] if fourth[k] * s < one else none
            constant += inside
            slope += inside * fourth[k]
        excess = constant - slope * s - most
        if excess <= np.float32(0.01) * most:
            break
        s += np.float32(0.9999) * excess / slope
    return s


@compiled()
def _alive(
    cloud: Any,
    center: Any,
    half: float,
    rho: float,
    tangency: float,
    lists: Any,
    lengths: Any,
    level: int,
    scratch: Any,
) -> Any:
    """Whether some leaf within rho may face away from the cell; drops farther leaves from the list."""
    mine, away = lists[level], scratch[2]
    kept, alive = 0, False
    for k in range(lengths[level]):
        sphere = cloud.spheres[mine[k]]
        if away[k] - sphere[3] - half > rho:
            continue
        if not alive:
            alive = _faces_away(sphere, cloud.cones[mine[k]], center, half, away[k], 0.5 * tangency)
        mine[kept] = mine[k]
        kept += 1
    lengths[level] = kept
    return alive


@compiled()
def _faces_away(sphere: Any, cone: Any, center: Any, half: float, distance: float, limit: float) -> Any:
    """Whether a normal of the leaf can be within acos(limit) of its direction from a point of the cell."""
    spread = sphere[3] + half
    if distance <= spread or cone[3] <= 0.0:
        return True
    dx, dy, dz = sphere[0] - center[0], sphere[1] - center[1], sphere[2] - center[2]
    along = (dx * cone[0] + dy * cone[1] + dz * cone[2]) / distance
    sine = spread / distance
    cosine = np.sqrt(1.0 - sine * sine)
    both_cos = cone[3] * cosine - cone[4] * sine  # half angle of the cone and of the direction together
    both_sin = cone[4] * cosine + cone[3] * sine
    if both_cos <= 0.0:
        return True
    # the angle between axis and direction is at most acos(limit) + acos(both_cos)
    return along >= limit * both_cos - np.sqrt(1.0 - limit * limit) * both_sin - 1e-6

"""Pairs of points whose candidate ball may pass: culled by tangency, radius, and the critical-radius grid.

All pairs go through one loop of single-precision SIMD without branches: with D, a_i, a_j as in `medial.ball`,
gap = a_i - a_j and E = D |n_i + n_j|^2 - 4 a_i a_j = D F^2,

    c = p_i - (D (n_i + n_j) / 2 - a_j d) / gap,      r^2 = D E / (2 gap)^2

cost one division. The few per cent whose radius is below the critical radius where their centre lies are
kept.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from medial.compiled import compiled, grown, ranges, run_tasks
from medial.similarity_grid import FINE, Grid
from medial.similarity_tree import LEAF, Cloud

MARGIN = 1.01  # of radii, in the single-precision test
LEAVES_PER_TASK = 16
RUN = 128  # leaves per call of the SIMD loop: its buffers stay in the first-level cache


class Pairs(NamedTuple):
    """Candidate pairs i < j in kd-tree order, grouped by the cell of their ball's centre.

    Attributes
    ----------
    i, j : (pairs,) int32
    starts : (cells + 1,) int64
        Cell c holds the pairs from ``starts[c]`` to ``starts[c + 1]``.
    """

    i: NDArray[np.int32]
    j: NDArray[np.int32]
    starts: NDArray[np.int64]


class Screen(NamedTuple):
    """What the single-precision test reads, relative to the middle of the cloud.

    Attributes
    ----------
    x, y, z, u, v, w : (n,) float32
        Positions and normals.
    box : (8,) float32
        Lowest corner of the fine and of the coarse table, cells per unit length of each.
    counts : (6,) float32
        Entries of the fine and of the coarse table along each axis.
    squares : (entries,) float32
        Squared critical radius of every entry of the table; negative where dead.
    least, largest : float32
        Bounds on F^2 and r^2.
    """

    x: NDArray[np.float32]
    y: NDArray[np.float32]
    z: NDArray[np.float32]
    u: NDArray[np.float32]
    v: NDArray[np.float32]
    w: NDArray[np.float32]
    box: NDArray[np.float32]
    counts: NDArray[np.float32]
    squares: NDArray[np.float32]
    least: np.float32
    largest: np.float32


def make_screen(cloud: Cloud, grid: Grid, tangency: float, cap: float) -> Screen:
    """Prepare the single-precision test."""
    positions = np.stack([cloud.x, cloud.y, cloud.z])
    middle = positions.mean(axis=1)
    x, y, z = (positions - middle[:, None]).astype(np.float32)
    u, v, w = (axis.astype(np.float32) for axis in (cloud.u, cloud.v, cloud.w))
    origin = grid.origin - middle
    corner = origin + grid.inner[0] * FINE * grid.size
    box = np.concatenate([corner, origin, [1 / grid.size, 1 / (FINE * grid.size)]]).astype(np.float32)
    counts = np.concatenate([(grid.inner[1] - grid.inner[0]) * FINE, grid.coarse]).astype(np.float32)
    squares = ((MARGIN * grid.cells[:, 0]) ** 2).astype(np.float32)
    squares[0] = -1
    least, largest = np.float32((tangency / MARGIN) ** 2), np.float32((MARGIN * cap) ** 2)
    return Screen(x, y, z, u, v, w, box, counts, squares[grid.table], least, largest)


def candidate_pairs(cloud: Cloud, grid: Grid, screen: Screen, cap: float, leaves: tuple[int, int]) -> Pairs:
    """Pairs that tangency, radius cap and critical radii let through, i in `leaves` (first, last + 1)."""
    spans = [(leaves[0] + a, leaves[0] + b) for a, b in ranges(leaves[1] - leaves[0], LEAVES_PER_TASK)]
    parts = run_tasks(_cull, [(screen, cloud.spheres, grid.table, cap, *span) for span in spans])
    i, j, cells = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return Pairs(*_grouped(i, j, cells, len(grid.cells)))


@compiled()
def _grouped(i: Any, j: Any, cells: Any, count: int) -> Any:
    """Counting sort by cell; stable, so the order does not depend on the number of threads."""
    starts = np.zeros(count + 1, np.int64)
    for k in range(len(cells)):
        starts[cells[k] + 1] += 1
    for c in range(count):
        starts[c + 1] += starts[c]
    place = starts[:-1].copy()
    sorted_i, sorted_j = np.empty_like(i), np.empty_like(j)
    for k in range(len(cells)):
        at = place[cells[k]]
        place[cells[k]] = at + 1
        sorted_i[at], sorted_j[at] = i[k], j[k]
    return sorted_i, sorted_j, starts


@compiled(fastmath={"contract", "arcp", "reassoc", "nsz"})
def _test(s: Any, i: int, x: Any, y: Any, z: Any, u: Any, v: Any, w: Any, places: Any, radii: Any) -> None:
    """Table entry and squared radius of the balls of point i with some others; entry 0 where discarded."""
    zero, quarter, half, one, four = (
        np.float32(0),
        np.float32(0.25),
        np.float32(0.5),
        np.float32(1),
        np.float32(4),
    )
    xi, yi, zi, ui, vi, wi = s.x[i], s.y[i], s.z[i], s.u[i], s.v[i], s.w[i]
    fx, fy, fz, gx, gy, gz, fine, wide = s.box
    lx, ly, lz, ox, oy, oz = s.counts
    before = one + lx * ly * lz
    for j in range(len(x)):
        dx, dy, dz = xi - x[j], yi - y[j], zi - z[j]
        square = dx * dx + dy * dy + dz * dz
        ai = ui * dx + vi * dy + wi * dz
        aj = u[j] * dx + v[j] * dy + w[j] * dz
        sx, sy, sz = ui + u[j], vi + v[j], wi + w[j]
        e = square * (sx * sx + sy * sy + sz * sz) - four * ai * aj
        gap = ai - aj
        inverse = one / gap
        g, back = half * square * inverse, aj * inverse
        cx, cy, cz = xi - (g * sx - back * dx), yi - (g * sy - back * dy), zi - (g * sz - back * dz)
        radius = quarter * square * e * inverse * inverse
        ix, iy, iz = (cx - fx) * fine, (cy - fy) * fine, (cz - fz) * fine
        inside = (ix >= zero) & (iy >= zero) & (iz >= zero) & (ix < lx) & (iy < ly) & (iz < lz)
        px = np.floor(ix if inside else min(max((cx - gx) * wide, zero), ox - one))
        py = np.floor(iy if inside else min(max((cy - gy) * wide, zero), oy - one))
        pz = np.floor(iz if inside else min(max((cz - gz) * wide, zero), oz - one))
        place = (px * (ly if inside else oy) + py) * (lz if inside else oz) + pz + (one if inside else before)
        passes = (gap > zero) & (e >= s.least * square) & (radius <= s.largest)
        places[j] = np.int32(place if passes else zero)
        radii[j] = radius


@compiled()
def _cull(screen: Any, spheres: Any, table: Any, cap: float, start: int, stop: int) -> Any:
    """Surviving pairs (i, j, cell) with i in leaves [start, stop) and j > i."""
    n, total = len(screen.x), len(spheres)
    room = 2 * n
    rows, cols, cells = np.empty(room, np.int32), np.empty(room, np.int32), np.empty(room, np.int32)
    places, radii = np.empty(RUN * LEAF, np.int32), np.empty(RUN * LEAF, np.float32)
    found = 0
    for a in range(start, stop):
        b = a
        while b < total:
            first, b = b, _run(spheres, a, b, cap)
            for i in range(a * LEAF, min(a * LEAF + LEAF, n)):
                begin, end = max(first * LEAF, i + 1), min(b * LEAF, n)
                if begin >= end:
                    continue
                if found + end - begin > room:
                    rows, cols, cells = grown(rows), grown(cols), grown(cells)
                    room *= 2
                _test(
                    screen, i, screen.x[begin:end], screen.y[begin:end], screen.z[begin:end],
                    screen.u[begin:end], screen.v[begin:end], screen.w[begin:end], places, radii,
                )  # fmt: skip
                for j in range(end - begin):
                    if radii[j] <= screen.squares[places[j]]:
                        rows[found], cols[found], cells[found] = i, begin + j, table[places[j]]
                        found += 1
            b = max(b, first + 1)
    return rows[:found].copy(), cols[:found].copy(), cells[:found].copy()


@compiled()
def _run(spheres: Any, a: int, first: int, cap: float) -> Any:
    """End of the run of leaves from `first` on that some ball may join to leaf a."""
    b = first
    while b < min(first + RUN, len(spheres)):
        dx, dy, dz = (
            spheres[a, 0] - spheres[b, 0],
            spheres[a, 1] - spheres[b, 1],
            spheres[a, 2] - spheres[b, 2],
        )
        far = spheres[a, 3] + spheres[b, 3] + 2.0 * cap
        if dx * dx + dy * dy + dz * dz > far * far:
            break
        b += 1
    return b

"""Pairs of points whose candidate ball may pass: culled by tangency, radius, and the critical-radius grid.

Pairs of leaves go first. With u = d / |d|, s = n_i + n_j, g = (n_i - n_j) . u and s' the part of s across u::

    F^2 = |s'|^2 + g^2,      r = |d| F / (2 g)

so bounds on |d|, |s'| and g over two leaves, from their spheres and cones of normals, tell where no pair can
have a ball that is tangent enough and small enough. All pairs of the other leaves go through one loop of
single-precision SIMD without branches: with D, a_i, a_j as in `candidate_ball`, gap = a_i - a_j and
E = D |n_i + n_j|^2 - 4 a_i a_j = D F^2::

    c = p_i - (D (n_i + n_j) / 2 - a_j d) / gap,      r^2 = D E / (2 gap)^2

cost one division. The few per cent whose radius is below the critical radius where their centre lies are
kept.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled, grown, ranges, run_tasks
from medial.similarity.candidate_ball import columns
from medial.similarity.critical_radius import FINE, Grid
from medial.similarity.leaves import LEAF, SortedCloud

MARGIN = 1.01  # of radii, in the single-precision test
LEAVES_PER_TASK = 16
RUN = 128  # leaves per call of the SIMD loop: its buffers stay in the first-level cache
ROUNDING = 1e-3  # of the bounds over two leaves, which are differences of numbers up to 4 in single precision


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


class _Leaves(NamedTuple):
    """Bounding spheres relative to the middle of the cloud, and cones of normals; (leaves,) float32 each.

    Attributes
    ----------
    x, y, z, radius
    u, v, w
        Mean normal.
    chord
        Largest distance of a normal from the mean one.
    """

    x: NDArray[np.float32]
    y: NDArray[np.float32]
    z: NDArray[np.float32]
    radius: NDArray[np.float32]
    u: NDArray[np.float32]
    v: NDArray[np.float32]
    w: NDArray[np.float32]
    chord: NDArray[np.float32]


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
    leaves : _Leaves
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
    leaves: _Leaves


def make_screen(cloud: SortedCloud, grid: Grid, tangency: float, cap: float) -> Screen:
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
    lx, ly, lz = columns(cloud.spheres[:, :3] - middle, np.float32)
    lu, lv, lw = columns(cloud.cones, np.float32)
    radius = cloud.spheres[:, 3].astype(np.float32)
    chord = np.sqrt(2 - 2 * cloud.cones[:, 3]).astype(np.float32)
    leaves = _Leaves(lx, ly, lz, radius, lu, lv, lw, chord)
    return Screen(x, y, z, u, v, w, box, counts, squares[grid.table], least, largest, leaves)


def candidate_pairs(grid: Grid, screen: Screen, leaves: tuple[int, int]) -> Pairs:
    """Pairs that tangency, radius cap and critical radii let through, i in `leaves` (first, last + 1)."""
    spans = [(leaves[0] + a, leaves[0] + b) for a, b in ranges(leaves[1] - leaves[0], LEAVES_PER_TASK)]
    parts = run_tasks(_cull, [(screen, grid.table, *span) for span in spans])
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


@compiled()
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
def _joined(leaves: Any, a: int, first: int, least: Any, largest: Any, kept: Any) -> None:
    """Whether some ball that may pass can touch leaf a and each of the leaves from `first` on."""
    zero, one, two, four, slack = (
        np.float32(0),
        np.float32(1),
        np.float32(2),
        np.float32(4),
        np.float32(ROUNDING),
    )
    xa, ya, za, ra = leaves.x[a], leaves.y[a], leaves.z[a], leaves.radius[a]
    ua, va, wa, chord = leaves.u[a], leaves.v[a], leaves.w[a], leaves.chord[a] + slack
    for k in range(len(kept)):
        b = first + k
        dx, dy, dz = xa - leaves.x[b], ya - leaves.y[b], za - leaves.z[b]
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        both = (ra + leaves.radius[b]) * (one + slack)
        inverse = one / max(length, np.float32(1e-30))
        sine = min(both * inverse, one)
        swing = np.sqrt(two - two * np.sqrt(one - sine * sine))  # of the direction u between their points
        off = chord + leaves.chord[b]
        sx, sy, sz = ua + leaves.u[b], va + leaves.v[b], wa + leaves.w[b]
        tx, ty, tz = ua - leaves.u[b], va - leaves.v[b], wa - leaves.w[b]
        square = sx * sx + sy * sy + sz * sz
        along = (sx * dx + sy * dy + sz * dz) * inverse
        across = np.sqrt(max(square - along * along, zero))
        wide = off + np.sqrt(square) * swing
        least_across, most_across = max(across - wide, zero), across + wide
        g = (tx * dx + ty * dy + tz * dz) * inverse + off + np.sqrt(tx * tx + ty * ty + tz * tz) * swing
        gap = max(length - both, zero)
        tangent = (g > zero) & (most_across * most_across + g * g >= least)
        small = gap * gap * (least_across * least_across + g * g) <= four * largest * g * g
        kept[k] = (length <= both) | (tangent & small)


@compiled()
def _cull(screen: Any, table: Any, start: int, stop: int) -> Any:
    """Surviving pairs (i, j, cell) with i in leaves [start, stop) and j > i."""
    n, total = len(screen.x), len(screen.leaves.x)
    room = 2 * n
    rows, cols, cells = np.empty(room, np.int32), np.empty(room, np.int32), np.empty(room, np.int32)
    places, radii = np.empty(RUN * LEAF, np.int32), np.empty(RUN * LEAF, np.float32)
    others, ids = np.empty((6, RUN * LEAF), np.float32), np.empty(RUN * LEAF, np.int32)
    kept = np.empty(total, np.bool_)
    found = 0
    for a in range(start, stop):
        _joined(screen.leaves, a, a, screen.least, screen.largest, kept[: total - a])
        b = a
        while b < total:
            b, count = _gather(screen, kept, a, b, others, ids)
            for i in range(a * LEAF, min(a * LEAF + LEAF, n)):
                if found + count > room:
                    rows, cols, cells = grown(rows), grown(cols), grown(cells)
                    room *= 2
                _test(
                    screen, i, others[0, :count], others[1, :count], others[2, :count],
                    others[3, :count], others[4, :count], others[5, :count], places, radii,
                )  # fmt: skip
                for k in range(count):
                    if radii[k] <= screen.squares[places[k]] and ids[k] > i:
                        rows[found], cols[found], cells[found] = i, ids[k], table[places[k]]
                        found += 1
    return rows[:found].copy(), cols[:found].copy(), cells[:found].copy()


@compiled()
def _gather(screen: Any, kept: Any, a: int, first: int, others: Any, ids: Any) -> Any:
    """Points of the kept leaves from `first` on, as many as there is room for: next leaf and their number."""
    b, count, n = first, 0, len(screen.x)
    while b < len(screen.leaves.x) and count + LEAF <= len(ids):
        if kept[b - a]:
            for j in range(b * LEAF, min(b * LEAF + LEAF, n)):
                others[0, count], others[1, count], others[2, count] = screen.x[j], screen.y[j], screen.z[j]
                others[3, count], others[4, count], others[5, count] = screen.u[j], screen.v[j], screen.w[j]
                ids[count] = j
                count += 1
        b += 1
    return b, count

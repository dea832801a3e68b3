"""Medial similarity (Eqs. 4-7) on a device: every pair of points in a thread of its own.

What the processor does with trees and runs of SIMD is done here by brute force and sorting:

1. every pair is tested in single precision against tangency, radius cap and critical radius;
2. the few per cent that survive are computed in double precision and sorted by the cell of their ball's
   centre, so that neighbouring threads read the same points;
3. each ball sums the depths of its points (Eq. 6), nearest leaves of its cell first, until it is too full or
   no leaf is left within its reach.

Nothing depends on the order in which threads run: each owns its outputs, and the sorts are stable.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from medial.device.leaf_lists import Lists, leaf_lists
from medial.device.sparse_pairs import symmetric_on
from medial.similarity.candidate_ball import SMALLEST_TANGENCY
from medial.similarity.candidate_pairs import Screen
from medial.similarity.critical_radius import Grid
from medial.similarity.emptiness import Settings
from medial.similarity.leaves import LEAF, SortedCloud

PAIRS_AT_ONCE = 2**25  # pairs of points tested before survivors are collected: bounds the memory


class _Tables(NamedTuple):
    """The critical-radius grid on the device, as in `Screen`, and the cell of every entry."""

    box: Any
    counts: Any
    squares: Any
    cells: Any


class _Points(NamedTuple):
    """Positions relative to the middle of the cloud, and normals: four values a point, the last unused."""

    places: Any
    normals: Any


class _Ball(NamedTuple):
    """Candidate balls: centre, squared radius, a_i - a_j, squared tangency F."""

    center: Any
    square: Any
    gap: Any
    tangency: Any


def similar_pairs(
    jit: Any,
    cloud: SortedCloud,
    order: NDArray[np.int64],
    grid: Grid,
    screen: Screen,
    settings: Settings,
) -> Iterator[tuple[Any, Any, Any]]:
    """Pairs of points whose similarity reaches the cut-off, a bounded number at a time.

    Parameters
    ----------
    jit
        ``drjit.cuda`` or ``drjit.llvm``.
    cloud, order
        The cloud in kd order, and the place of its points in the caller's arrays.
    grid, screen
        Critical radii, and the bounds of the single-precision test.
    settings
        Parameters of Eq. 7 and the smallest similarity kept.

    Yields
    ------
    i, j, phi : (pairs,) UInt32, UInt32, Float64
        On the device, every pair once, in the caller's numbers.
    """
    if len(grid.cells) == 1:
        return  # all of space is too full
    n = len(cloud.x)
    middle = np.stack([cloud.x, cloud.y, cloud.z]).mean(axis=1)
    places = np.stack([cloud.x, cloud.y, cloud.z], axis=1) - middle
    normals = np.stack([cloud.u, cloud.v, cloud.w], axis=1)
    single, double = (_Points(*_packed(kind, places, normals)) for kind in (jit.Float, jit.Float64))
    tables = _Tables(
        jit.Float(screen.box), jit.Float(screen.counts), jit.Float(screen.squares), jit.UInt32(grid.table)
    )
    lists = leaf_lists(jit, places, cloud.mass, grid, middle)
    limits, given = jit.Float64([*settings]), jit.UInt32(order.astype(np.uint32))
    rows = max(PAIRS_AT_ONCE // n, 1)
    for first in range(1, n // 2 + 1, rows):
        last = min(first + rows, n // 2 + 1)
        pairs = _culled(jit, single, tables, screen, n, (first, last))
        if pairs is not None:
            i, j, phi = _similar(jit, double, tables, lists, limits, *pairs)
            if dr.width(phi):
                i, j = dr.gather(jit.UInt32, given, i), dr.gather(jit.UInt32, given, j)
                dr.eval(i, j, phi)
                yield i, j, phi


def joined(jit: Any, parts: list[tuple[Any, Any, Any]], n: int) -> csr_array:
    """The (n, n) matrix of all parts."""
    if not parts:
        return csr_array((n, n))
    i, j, phi = (dr.concat([part[k] for part in parts]) for k in range(3))
    return symmetric_on(jit, i, j, phi, n)


def _packed(kind: Any, *arrays: NDArray[np.float64]) -> list[Any]:
    """Arrays of (n, 3) values in memory of the device, four values a point."""
    return [dr.opaque(kind(np.pad(array, ((0, 0), (0, 1))).ravel())) for array in arrays]


def _vector(jit: Any, source: Any, index: Any, active: Any = True) -> Any:
    """The three values of a point, in the precision of the source."""
    double = isinstance(source, jit.Float64)
    four = dr.gather(jit.Array4f64 if double else jit.Array4f, source, index, active)
    return (jit.Array3f64 if double else jit.Array3f)(four.x, four.y, four.z)


def _candidates(jit: Any, points: _Points, i: Any, j: Any) -> _Ball:
    """Candidate balls of pairs of points (`medial.similarity.candidate_ball`), with one division."""
    p, n = _vector(jit, points.places, i), _vector(jit, points.normals, i)
    q, m = _vector(jit, points.places, j), _vector(jit, points.normals, j)
    d, s = p - q, n + m
    square, ai, aj = dr.squared_norm(d), dr.dot(n, d), dr.dot(m, d)
    gap, e = ai - aj, square * dr.squared_norm(s) - 4 * ai * aj
    inverse = 1 / gap
    center = p - (0.5 * square * inverse * s - aj * inverse * d)
    return _Ball(center, 0.25 * square * e * inverse * inverse, gap, e / square)


def _entry(jit: Any, tables: _Tables, center: Any, active: Any) -> Any:
    """Entry of the grid's table that covers a point; 0, which is dead, where not active."""
    kind = jit.Float64 if isinstance(center, jit.Array3f64) else jit.Float
    box = [kind(dr.gather(jit.Float, tables.box, k)) for k in range(8)]
    counts = [kind(dr.gather(jit.Float, tables.counts, k)) for k in range(6)]
    fine = [(center[k] - box[k]) * box[6] for k in range(3)]
    wide = [dr.clip((center[k] - box[3 + k]) * box[7], 0, counts[3 + k] - 1) for k in range(3)]
    inside = active
    for k in range(3):
        inside = inside & (fine[k] >= 0) & (fine[k] < counts[k])
    x, y, z = (jit.UInt32(dr.select(active, dr.select(inside, fine[k], wide[k]), 0)) for k in range(3))
    lx, ly, lz, _, oy, oz = (jit.UInt32(count) for count in counts)
    place = (x * dr.select(inside, ly, oy) + y) * dr.select(inside, lz, oz) + z
    return dr.select(active, place + dr.select(inside, 1, 1 + lx * ly * lz), 0)


def _culled(
    jit: Any, points: _Points, tables: _Tables, screen: Screen, n: int, steps: tuple[int, int]
) -> tuple[Any, Any] | None:
    """Pairs (i, i + step modulo n) that the single-precision test lets through, smaller index first, if any.

    Steps up to n / 2 meet every pair once; the last one, if n is even, meets it twice.
    """
    first, count = dr.opaque(jit.UInt32, steps[0]), dr.opaque(jit.UInt32, n)
    k = dr.arange(jit.UInt32, (steps[1] - steps[0]) * n)

    def pair(k: Any) -> tuple[Any, Any, Any]:
        step = k // count
        i = k - step * count
        step += first
        j = dr.select(i + step < count, i + step, i + step - count)
        return dr.minimum(i, j), dr.maximum(i, j), (2 * step < count) | (i < j)

    i, j, once = pair(k)
    ball = _candidates(jit, points, i, j)
    least, largest = dr.opaque(jit.Float, screen.least), dr.opaque(jit.Float, screen.largest)
    passes = once & (ball.gap > 0) & (ball.tangency >= least) & (ball.square <= largest)
    entry = _entry(jit, tables, ball.center, passes)
    passes &= ball.square <= dr.gather(jit.Float, tables.squares, entry, passes)
    survivors = dr.compress(passes)
    return pair(survivors)[:2] if dr.width(survivors) else None


def _similar(
    jit: Any, points: _Points, tables: _Tables, lists: Lists, limits: Any, i: Any, j: Any
) -> tuple[Any, Any, Any]:
    """Those of some pairs whose similarity reaches the cut-off, and their similarity (Eq. 7)."""
    sigma_e, sigma_t, budget, cap, cutoff = (dr.gather(jit.Float64, limits, k) for k in range(5))
    cell = _cells(jit, points, tables, i, j, cap)
    order: Any = dr.argsort(cell)
    i, j, cell = (dr.gather(jit.UInt32, each, order) for each in (i, j, cell))
    ball = _candidates(jit, points, i, j)
    tilt = 4 * dr.maximum(2 - dr.sqrt(ball.tangency), 0) / (sigma_t * sigma_t)  # (tau / sigma_t)^2, Eq. 4
    alive = (cell > 0) & (tilt < budget)
    most = jit.Float(sigma_e * dr.sqrt(dr.maximum(budget - tilt, 0)))
    depth = _depths(jit, lists, ball, cell, most, alive)
    gamma = jit.Float64(depth) / sigma_e
    phi = dr.exp(-gamma * gamma - tilt)
    similar = alive & (depth <= most) & (phi >= cutoff)
    dr.eval(i, j, phi, similar)  # at once, lest the loop run for each of them
    kept: Any = dr.compress(similar)
    i, j = (dr.gather(jit.UInt32, each, kept) for each in (i, j))
    return i, j, dr.gather(jit.Float64, phi, kept)


def _cells(jit: Any, points: _Points, tables: _Tables, i: Any, j: Any, cap: Any) -> Any:
    """Cells of the balls' centres, in double precision; 0 where there is no ball or it is too large."""
    ball = _candidates(jit, points, i, j)
    passes = (ball.gap > 0) & (ball.tangency > SMALLEST_TANGENCY**2) & (ball.square <= cap * cap)
    entry = _entry(jit, tables, ball.center, passes)
    passes &= ball.square <= jit.Float64(dr.gather(jit.Float, tables.squares, entry, passes))
    return dr.gather(jit.UInt32, tables.cells, entry, passes)


def _depths(jit: Any, lists: Lists, ball: _Ball, cell: Any, most: Any, alive: Any) -> Any:
    """Summed depths (Eqs. 5-6) of some balls; more than `most` where they were found to be too full.

    Centres are split into a single-precision number and what it lacks, so that distances to near points
    keep all their digits although everything is summed in single precision.
    """
    high = jit.Array3f(ball.center)
    low = jit.Array3f(ball.center - jit.Array3f64(high))
    radius = jit.Float(dr.sqrt(ball.square))
    inverse = jit.Float(1 / ball.square)
    off = (high - _vector(jit, lists.centers, cell, alive)) + low
    outer = (radius + dr.norm(off)) * (1 + 1e-6)
    last = dr.gather(jit.UInt32, lists.starts, cell + 1, alive)

    def add(depth: Any, leaf: Any, offset: Any) -> Any:
        for k in range(LEAF):
            point = dr.gather(jit.Array4f, lists.points, leaf * LEAF + k)
            q = dr.squared_norm(offset - jit.Array3f(point.x, point.y, point.z)) * inverse
            depth += point.w * dr.maximum(1 - q * q, 0)
        return depth

    def step(at: Any, depth: Any) -> tuple[Any, Any]:
        leaf = dr.gather(jit.UInt32, lists.leaves, at)
        sphere = dr.gather(jit.Array4f, lists.spheres, leaf)
        offset = (high - jit.Array3f(sphere.x, sphere.y, sphere.z)) + low
        touched = dr.squared_norm(offset) <= dr.square(radius + sphere.w)
        depth = dr.if_stmt((depth, leaf, offset), touched, add, lambda depth, leaf, offset: depth)
        return at + 1, depth

    def goes_on(at: Any, depth: Any) -> Any:
        more = (at < last) & (depth <= most)
        return more & (dr.gather(jit.Float, lists.near, at, more) <= outer)

    at = dr.gather(jit.UInt32, lists.starts, cell, alive)
    return dr.while_loop((at, dr.zeros(jit.Float, dr.width(cell))), goes_on, step)[1]

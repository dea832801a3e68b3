"""On a device: the leaves that balls of every cell of the critical-radius grid can reach, nearest first."""

from typing import Any, NamedTuple

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from medial.similarity.candidate_pairs import MARGIN
from medial.similarity.critical_radius import FINE, FINENESS, Grid
from medial.similarity.leaves import LEAF

TESTS_AT_ONCE = 2**25  # cells times leaves


class Lists(NamedTuple):
    """Leaves in reach of each cell.

    Attributes
    ----------
    starts : (cells + 1,)
        Cell c has the entries from ``starts[c]`` to ``starts[c + 1]``.
    leaves, near : (entries,)
        Leaf, and the distance of its sphere from the cell's centre: ascending in every cell.
    centers : (4 cells,)
        Centres of the cells relative to the middle of the cloud; every fourth value is unused.
    spheres : (4 leaves,)
        Centre, relative to the middle of the cloud, and radius of a sphere around each leaf.
    points : (4 points,)
        Positions relative to the centre of their leaf, and weights, eight for every leaf.
    """

    starts: Any
    leaves: Any
    near: Any
    centers: Any
    spheres: Any
    points: Any


def leaf_lists(
    jit: Any, places: NDArray[np.float64], mass: NDArray[np.float64], grid: Grid, middle: NDArray[np.float64]
) -> Lists:
    """Make the lists.

    Parameters
    ----------
    jit
        ``drjit.cuda`` or ``drjit.llvm``.
    places : (n, 3)
        Positions in kd order, relative to `middle`.
    mass : (n,)
        Weights.
    grid
        The critical-radius grid; no ball of a cell is larger than its critical radius.
    middle : (3,)
        Middle of the cloud.
    """
    spheres, points = leaf_blocks(places, mass)
    half = np.maximum(FINENESS * grid.cells[:, 0], FINE * 0.8661 * grid.size)  # bounds their half diagonals
    reach = MARGIN * grid.cells[:, 0] + 2 * half
    reach[0] = -np.inf
    cells = np.column_stack([grid.cells[:, 1:] - middle, reach])
    cells[0, :3] = 0
    flat = (cells.astype(np.float32).ravel(), spheres.ravel(), points.ravel())
    centers, balls, offsets = (dr.opaque(jit.Float(each)) for each in flat)
    cell, leaf, near = _within(jit, centers, balls, len(cells), len(spheres))
    order: Any = dr.argsort(near)
    order = dr.gather(jit.UInt32, order, dr.argsort(dr.gather(jit.UInt32, cell, order)))
    counts = dr.zeros(jit.UInt32, len(cells) + 1)
    dr.scatter_add(counts, jit.UInt32(1), cell)
    leaf, near = dr.gather(jit.UInt32, leaf, order), dr.gather(jit.Float, near, order)
    return Lists(dr.prefix_sum(counts), leaf, near, centers, balls, offsets)


def leaf_blocks(
    places: NDArray[np.float64], mass: NDArray[np.float64]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Spheres around every eight points, and the points relative to their centres.

    Returns
    -------
    spheres : (leaves, 4) float32
        Centre and radius.
    points : (8 leaves, 4) float32
        Position and weight; weightless points fill the last leaf.
    """
    missing = -len(places) % LEAF
    blocks = np.concatenate([places, np.repeat(places[-1:], missing, axis=0)]).reshape(-1, LEAF, 3)
    centers = (0.5 * (blocks.min(axis=1) + blocks.max(axis=1))).astype(np.float32)
    relative = (blocks - centers[:, None].astype(np.float64)).astype(np.float32)
    radii = np.linalg.norm(relative, axis=2).max(axis=1) * np.float32(1 + 1e-6)
    weights = np.pad(mass, (0, missing)).astype(np.float32)
    return np.column_stack([centers, radii]), np.column_stack([relative.reshape(-1, 3), weights])


def _within(jit: Any, cells: Any, spheres: Any, count: int, total: int) -> tuple[Any, Any, Any]:
    """Pairs of cell and leaf within the cell's reach, by cell, and their distances."""
    parts = []
    rows = max(TESTS_AT_ONCE // total, 1)
    for first in range(0, count, rows):
        k = dr.arange(jit.UInt32, (min(first + rows, count) - first) * total)
        start, each = dr.opaque(jit.UInt32, first), dr.opaque(jit.UInt32, total)

        def measure(k: Any, start: Any = start, each: Any = each) -> tuple[Any, Any, Any, Any]:
            row = k // each
            cell, leaf = start + row, k - row * each
            a, b = dr.gather(jit.Array4f, cells, cell), dr.gather(jit.Array4f, spheres, leaf)
            away = dr.sqrt(dr.square(a.x - b.x) + dr.square(a.y - b.y) + dr.square(a.z - b.z)) - b.w
            return cell, leaf, dr.maximum(away, 0), away <= a.w

        found = dr.compress(measure(k)[3])
        if dr.width(found):
            cell, leaf, near, _ = measure(found)
            dr.eval(cell, leaf, near)
            parts.append((cell, leaf, near))
    cell, leaf, near = (dr.concat([part[k] for part in parts]) for k in range(3))
    return cell, leaf, near

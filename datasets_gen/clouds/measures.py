"""Measures of a bare cloud, as ``medialbench inspect`` prints them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from datasets_gen.clouds.point_cloud import Array
from datasets_gen.clouds.precision import Rounding, rounding_of
from datasets_gen.points.neighbours import query_tree
from datasets_gen.points.outside import winding_numbers
from datasets_gen.points.strays import stray_points

GAP = 5.0
"""Median distances of neighbours between groups of points from which they are apart."""
NEIGHBOURS = 8
SMALLEST_GROUP = 20
"""Points of a group that counts."""
MOST = 20_000
"""Points that are looked at for sides and for what is missing; of larger clouds a part, picked at random."""
FULL = 1.1
"""Twice the mean winding number of complete bodies: areas are taken from neighbours' distances, a tenth too
large."""
OUTWARD = 0.9
"""Share of outward normals below which winding numbers do not tell what is missing."""
UNITS = (("m", 0.3, 3.5), ("cm", 30.0, 350.0), ("mm", 350.0, 3500.0))
"""Longest sides of a person or of an animal."""


@dataclass(frozen=True)
class CloudMeasures:
    """What a cloud is like.

    Attributes
    ----------
    points : int
    low, high : (3,) float64
        Corners of the bounding box.
    spacing : (3,) float64
        Distance to the nearest point at another place: median, and the range of the middle 90 %.
    copies : int
        Points at the place of an earlier one.
    stray : int
        Few, and far from all others.
    groups : int
        Groups of at least 20 points, more than five median spacings apart.
    rounding : Rounding
    units : str
        Guessed from the size, as if this were a person or an animal; empty if no unit fits.
    """

    points: int
    low: Array
    high: Array
    spacing: Array
    copies: int
    stray: int
    groups: int
    rounding: Rounding
    units: str


def measure_cloud(points: Array) -> CloudMeasures:
    """Measure a cloud (n, 3) of at least one finite point."""
    stray = stray_points(points)
    places, body = np.unique(points, axis=0), points[~stray]
    sides = np.ptp(body, axis=0)
    return CloudMeasures(
        len(points),
        points.min(axis=0),
        points.max(axis=0),
        *_spacing_and(places, points),
        int(stray.sum()),
        _groups(np.unique(body, axis=0)),
        rounding_of(points),
        next((unit for unit, low, high in UNITS if low <= sides.max() < high), ""),
    )


def _spacing_and(places: Array, points: Array) -> tuple[Array, int]:
    """Distances of neighbours, and the number of copies."""
    copies = len(points) - len(places)
    if len(places) < 2:
        return np.zeros(3), copies
    gap = query_tree(cKDTree(places), places, k=2)[0][:, 1]
    return np.quantile(gap, [0.5, 0.05, 0.95]), copies


def _groups(places: Array) -> int:
    """Groups of places without a gap of `GAP` median spacings between them."""
    n = len(places)
    if n < 2:
        return n
    gap, near = query_tree(cKDTree(places), places, k=min(NEIGHBOURS, n - 1) + 1)
    rows = np.repeat(np.arange(n), near.shape[1])
    close = gap.ravel() <= GAP * float(np.median(gap[:, 1]))
    graph = coo_array((np.ones(close.sum()), (rows[close], near.ravel()[close])), shape=(n, n))
    sizes = np.bincount(connected_components(graph, directed=False)[1])
    return max(1, int((sizes >= SMALLEST_GROUP).sum()))


def part_of(count: int) -> NDArray[np.int64]:
    """Ids of at most `MOST` of so many points, always the same."""
    picked: Any = np.random.default_rng(0).permutation(count)[:MOST]
    return np.sort(picked)


def missing_share(points: Array, normals: Array) -> float | None:
    """Share of the surface that a cloud lacks, by how much of it each point sees from within.

    A point of a closed surface sees half a sphere, whatever the shape; less where some is missing, by as much
    as the missing part would fill. On scans of two people and a horse, complete or with 44 to 61 % missing,
    it was within 0.2 of the truth.

    Parameters
    ----------
    points, normals : (n, 3)
        Outward, of unit length.

    Returns
    -------
    float or None
        In [0, 1]; None where the normals do not all point outward.
    """
    winding = winding_numbers(points, normals)
    if (winding > 0).mean() < OUTWARD:
        return None
    return float(np.clip(1 - 2 * winding.mean() / FULL, 0, 1))

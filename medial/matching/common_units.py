"""Two clouds in common units, and the neighbourhoods that follow the body rather than space."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from medial.diffusion import Diffusion
from medial.matching.landmarks.samples import farthest_points

Float = NDArray[np.float64]
Int = NDArray[np.int64]

MOST_POINTS = 8000
"""Points of a cloud that the search sees; what it finds is carried over to all points in the end."""
GROSS = 1.4
"""Ratio of sizes up to which two clouds may be scans of one subject in the same units."""


@dataclass(frozen=True)
class Cloud:
    """A cloud in the units of its pair: lengths are in square roots of the surface area.

    Attributes
    ----------
    points, normals, centers : (n, 3) float64
        Medial centres are the points themselves for surface operators.
    radii : (n,) float64
        Medial radii; 0 for surface operators.
    """

    points: Float
    normals: Float
    centers: Float
    radii: Float

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    @property
    def features(self) -> Float:
        """Positions and medial centres, (n, 6): near in both means near along the body."""
        return np.hstack([self.points, self.centers])


def common_units(source: Diffusion, target: Diffusion) -> tuple[Cloud, Cloud]:
    """Both clouds in square roots of the larger one's area."""
    scale = relative_scale(source, target)
    unit = float(np.sqrt(max(source.areas.sum(), target.areas.sum() * scale**2)))
    clouds = (
        Cloud(d.points * factor, d.normals, d.centers * factor, d.radii * factor)
        for d, factor in ((source, 1 / unit), (target, scale / unit))
    )
    first, second = clouds
    return first, second


def relative_scale(source: Diffusion, target: Diffusion) -> float:
    """Factor that brings the target to the source's units; 1 unless the clouds' sizes differ grossly.

    Scans of one subject share their units. Each estimate of a ratio of sizes has its weakness, so the units
    differ only if all of them say so; then their median tells by how much.
    """
    found = zip(sizes(source), sizes(target), strict=True)
    ratios = np.array([here / there for here, there in found if here > 0 and there > 0])
    if (ratios < 1 / GROSS).all() or (ratios > GROSS).all():
        return float(np.exp(np.median(np.log(ratios))))
    return 1.0


def sizes(diffusion: Diffusion) -> tuple[float, float, float]:
    """Lengths that tell how large a body is, each with its own weakness; 0 where unknown.

    Returns
    -------
    radius
        Median medial radius; too large where empty balls span limbs whose surfaces are missing.
    side
        Square root of the area; too small where much is missing.
    spread
        Root mean square distance from the centre of mass; depends on the pose, and on which part is missing.
    """
    areas = diffusion.areas
    centred = diffusion.points - np.average(diffusion.points, axis=0, weights=areas)
    spread = np.sqrt(np.average((centred**2).sum(axis=1), weights=areas))
    return float(np.median(diffusion.radii)), float(np.sqrt(areas.sum())), float(spread)


def farthest_order(points: Float, count: int) -> Int:
    """The first `count` points in farthest-point order, from the point farthest from the mean."""
    centred = points - points.mean(axis=0)
    return farthest_points(centred, count, int((centred**2).sum(axis=1).argmax()))


def neighbour_pairs(tree: cKDTree, positions: Float, neighbours: int) -> Int:
    """Pairs of nearest neighbours; separate parts are joined where their positions are closest.

    Parameters
    ----------
    tree
        Of K nodes' features.
    positions : (K, d)
    neighbours

    Returns
    -------
    (E, 2) int64
        Each pair once, the smaller id first; connected.
    """
    count = len(positions)
    _, near = tree.query(tree.data, k=min(neighbours + 1, count))
    near = near.reshape(count, -1)[:, 1:]
    pairs = np.column_stack([np.repeat(np.arange(count), near.shape[1]), near.ravel()])
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    while True:
        graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
        parts, label = connected_components(graph, directed=False)
        if parts <= 1:
            return pairs[pairs[:, 0] != pairs[:, 1]].astype(np.int64)
        smallest = label == np.bincount(label).argmin()
        here, there = np.flatnonzero(smallest), np.flatnonzero(~smallest)
        gap, closest = cKDTree(positions[there]).query(positions[here])
        best = np.argsort(gap, kind="stable")[:2]
        bridge = np.sort(np.column_stack([here[best], there[closest[best]]]), axis=1)
        pairs = np.unique(np.concatenate([pairs, bridge]), axis=0)

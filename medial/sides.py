"""Sides that the normals of neighbouring points are on: patches of one side, and seams between patches."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial import cKDTree

from datasets_gen.points.neighbours import query_tree

Float = NDArray[np.float64]
Ids = NDArray[np.int64]
Mask = NDArray[np.bool_]

NEIGHBOURS = 6
AGREE = 0.5
"""Cosine of two normals from which neighbours are of one patch; below minus this they are opposite."""
BESIDE = 0.5
"""Distance from the tangent plane, over the distance, up to which a neighbour may be of one patch."""
BESIDE_SEAM = 0.35
"""The same across a seam, from both tangent planes: the other sheet of a thin part is above or below."""
SMALLEST_PATCH, PATCH_SHARE = 20, 0.005
"""Points of a patch whose side is decided by itself, and their share of all."""


@dataclass(frozen=True)
class Neighbours:
    """Pairs of each point and its nearest ones.

    Attributes
    ----------
    points : (n, 3) float64
    rows, columns : (p,) int64
        Point ids of a pair.
    distances : (p,) float64
    """

    points: Float
    rows: Ids
    columns: Ids
    distances: Float

    @classmethod
    def of(cls, points: Float) -> "Neighbours":
        """Find the `NEIGHBOURS` nearest points of each of (n, 3); all others if there are fewer."""
        n = len(points)
        count = min(NEIGHBOURS, n - 1)
        distances, near = query_tree(cKDTree(points), points, k=count + 1)
        rows = np.repeat(np.arange(n), count)
        return cls(points, rows, near[:, 1:].ravel(), distances[:, 1:].ravel())

    def disagreement(self, normals: Float) -> float:
        """Share of the pairs whose normals point into opposite half spaces."""
        return float((self._cosines(normals) < 0).mean())

    def at_seams(self, normals: Float) -> Mask:
        """Which pairs lie across a seam: in each other's tangent plane, with opposite normals; (p,).

        Where a surface turns sharply or is thin, such neighbours are above or below each other's plane.
        Sheets that are much closer than points of one sheet cannot be told from seams.

        Parameters
        ----------
        normals : (n, 3)
            Unit.
        """
        here, there = self._heights(normals)
        flat = np.maximum(here, there) < BESIDE_SEAM * self.distances
        return np.asarray(flat & (self._cosines(normals) < -AGREE))

    def patches(self, normals: Float) -> list[Ids]:
        """Point ids of every connected part of the surface on which normals agree, if it is large enough.

        Neighbours on opposite sheets of a thin part are no neighbours here.
        """
        n = len(self.points)
        agree = (self._cosines(normals) > AGREE) & (self._heights(normals)[0] < BESIDE * self.distances)
        edges = (np.ones(agree.sum()), (self.rows[agree], self.columns[agree]))
        label = connected_components(coo_array(edges, shape=(n, n)), directed=False)[1]
        order = np.argsort(label, kind="stable")
        parts = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
        least = max(SMALLEST_PATCH, PATCH_SHARE * n)
        return [part for part in parts if len(part) >= least]

    def without_seams(self, normals: Float, patches: list[Ids]) -> Mask:
        """Which normals to turn so that patches agree across their seams, (n,); the largest patch is kept.

        Patches pass the side on to those with which they share the longest seams (maximum spanning tree).

        Parameters
        ----------
        normals : (n, 3)
        patches
            Of `patches`.
        """
        turned = np.zeros(len(self.points), dtype=bool)
        if len(patches) < 2:
            return turned
        label = np.full(len(turned), -1, np.int32)  # as SciPy's trees want it
        for number, ids in enumerate(patches):
            label[ids] = number
        seams = self.at_seams(normals)
        here, there = label[self.rows[seams]], label[self.columns[seams]]
        between = (here != there) & (here >= 0) & (there >= 0)
        lengths = coo_array(
            (np.ones(between.sum()), (here[between], there[between])), shape=(len(patches), len(patches))
        ).tocsr()
        tree = minimum_spanning_tree(-(lengths + lengths.T))
        largest = int(np.argmax([len(ids) for ids in patches]))
        order, parents = breadth_first_order(tree, largest, directed=False)
        against = np.zeros(len(patches), dtype=bool)
        for number in order[1:]:
            against[number] = ~against[parents[number]]
        turned[label >= 0] = against[label[label >= 0]]
        return turned

    def _cosines(self, normals: Float) -> Float:
        """Between the normals of each pair, (p,)."""
        return np.asarray(np.einsum("ij,ij->i", normals[self.rows], normals[self.columns]))

    def _heights(self, normals: Float) -> tuple[Float, Float]:
        """Distance of each pair's second point from the tangent plane of the first, and the reverse."""
        offset = self.points[self.columns] - self.points[self.rows]
        first, second = (np.einsum("ij,ij->i", offset, normals[ids]) for ids in (self.rows, self.columns))
        return np.abs(first), np.abs(second)

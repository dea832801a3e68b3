"""Which points are neighbours on a body: near each other, and not across a gap between two of its parts."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from datasets_gen.points.neighbours import neighbour_pairs, query_tree

Float = NDArray[np.float64]
Int = NDArray[np.int64]

SPACING_NEIGHBOURS = 6
"""The spacing of a cloud is the median distance to this neighbour, some 1.3 edges of a square cell."""


@dataclass(frozen=True)
class SurfaceGraph:
    """Points with normals, and the pairs of them that are neighbours on the body.

    Attributes
    ----------
    points, normals : (n, 3) float64
        Distinct points; unit outward normals.
    pairs : (E, 2) int64
        Each pair once.
    spacing : float
        Of the points.
    """

    points: Float
    normals: Float
    pairs: Int
    spacing: float

    @classmethod
    def of(cls, points: Float, normals: Float, neighbours: int) -> "SurfaceGraph":
        """Join nearest neighbours, but for those that face each other.

        Two points face each other if their normals are more than a right angle apart and the way from one to
        the other begins outside the body, as between two legs. On a thin part, where that way leads through
        the body, both sides stay joined. (The published neighbourhood is a Mahalanobis ball, whose radius
        has to be chosen for every shape.)

        Parameters
        ----------
        points, normals : (n, 3)
        neighbours
            Of each point.
        """
        tree = cKDTree(points)
        pairs = neighbour_pairs(tree, neighbours)
        i, j = pairs.T
        way, turn = points[j] - points[i], normals[i] - normals[j]
        opposite = np.einsum("ed,ed->e", normals[i], normals[j]) < 0
        facing = opposite & (np.einsum("ed,ed->e", way, turn) > 0)
        nearest = query_tree(tree, points, k=SPACING_NEIGHBOURS + 1)[0]
        return cls(points, normals, pairs[~facing], float(np.median(nearest[:, -1])))

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    def matrix(self) -> csr_array:
        """Symmetric (n, n) matrix with a 1 for each pair; rows in ascending order."""
        i, j = self.pairs.T
        both = (np.concatenate([i, j]), np.concatenate([j, i]))
        found = csr_array((np.ones(2 * len(i)), both), shape=(len(self), len(self)))
        found.sort_indices()
        return found

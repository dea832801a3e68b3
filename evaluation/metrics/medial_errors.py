"""Errors between medial regions: how far the right place and the found one are apart within the body.

Both places go by the medial centres of the nearest samples of the rest pose. Between two feet that stand side
by side the straight distance of the centres is short; the distance along the body leads up one leg and down
the other. It may exceed the geodesic distance, as the way through the trunk leads through its middle.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.compiled import ranges
from medial.diffusion import Diffusion
from medial.matching.common_units import CloudInUnits
from medial.matching.landmarks.medial_paths import MedialPaths

Float = NDArray[np.float64]

NODES = 1500
"""Samples of the rest pose between which paths are found."""
BLOCK = 64
"""Places whose distances to all samples are held at once."""


@dataclass(frozen=True)
class MedialRuler:
    """Distances between the medial regions of places on a rest pose.

    Attributes
    ----------
    diffusion : Diffusion
        Medial, of a complete sampling of the rest pose.
    paths : MedialPaths
        Path lengths through the medial structure, in the units of the rest pose.
    tree : cKDTree
        Of the samples.
    """

    diffusion: Diffusion
    paths: MedialPaths
    tree: cKDTree

    @classmethod
    def of(cls, diffusion: Diffusion) -> "MedialRuler":
        """The ruler of a rest pose: paths between at most `NODES` samples, and the samples' tree."""
        cloud = CloudInUnits(diffusion.points, diffusion.normals, diffusion.centers, diffusion.radii)
        return cls(diffusion, MedialPaths.of(cloud, min(NODES, len(cloud))), cKDTree(diffusion.points))

    def distances(self, right: Float, found: Float) -> tuple[Float, Float]:
        """Straight distances between the medial centres of right and found places, and along the body.

        With centres c and c' and the nodes k and l of the paths that are nearest to the two places, the
        distance along the body is ``max(|c - c'|, L_kl - |c - c_k| - |c' - c_l|)``: no shorter than the
        straight line, and else a lower bound (triangle inequality) of a path that leads through the nodes.
        `L` includes 2 % of the way on the surface and the zigzag between nodes around a limb, which is less
        than the limb's radius.

        Parameters
        ----------
        right, found : (n, 3)
            Places on the rest pose.

        Returns
        -------
        straight, along : (n,) float64
            In the units of the rest pose.
        """
        here, there = (self.tree.query(each)[1] for each in (right, found))
        return self._between(here, there)

    def mean_distances(self, right: Float) -> tuple[Float, Float]:
        """Means of `distances` from right places to all of the body: what a random match is off by.

        Parameters
        ----------
        right : (n, 3)

        Returns
        -------
        straight, along : (n,) float64
            In the units of the rest pose.
        """
        here = self.tree.query(right)[1]
        areas = self.diffusion.areas
        everywhere, weights = np.arange(len(areas)), areas / areas.sum()
        means = np.empty((2, len(right)))
        for rows in ranges(len(right), BLOCK):
            block = slice(*rows)
            means[:, block] = [each @ weights for each in self._between(here[block, None], everywhere)]
        return means[0], means[1]

    def _between(self, here: NDArray[np.int64], there: NDArray[np.int64]) -> tuple[Float, Float]:
        """`distances` between samples by their ids, which are broadcast."""
        centers, paths = self.diffusion.centers, self.paths
        straight = np.linalg.norm(centers[here] - centers[there], axis=-1)
        to_node = np.linalg.norm(centers - centers[paths.nodes[paths.nearest]], axis=1)
        along = paths.lengths[paths.nearest[here], paths.nearest[there]] - to_node[here] - to_node[there]
        return straight, np.maximum(straight, along)

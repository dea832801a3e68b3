"""Errors between medial regions: how far the right place and the found one are apart within the body.

Both places go by the medial centres of the nearest samples of the rest pose. Between two feet that stand side
by side the straight distance of the centres is short; the distance along the body leads up one leg and down
the other. It may exceed the geodesic distance, as the way through the trunk leads through its middle.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.compiled import ranges
from medial.diffusion import Diffusion
from medial.matching.common_units import CloudInUnits
from medial.matching.landmarks.medial_paths import MedialPaths

NODES = 1500
"""Samples of the rest pose between which paths are found."""
BLOCK = 64
"""Places whose distances to all samples are held at once."""


def medial_paths(diffusion: Diffusion) -> MedialPaths:
    """Path lengths through the medial structure of a body, in its own units.

    Parameters
    ----------
    diffusion
        Medial, of a complete sampling of the rest pose.
    """
    cloud = CloudInUnits(diffusion.points, diffusion.normals, diffusion.centers, diffusion.radii)
    return MedialPaths.of(cloud, min(NODES, len(cloud)))


def medial_distances(
    diffusion: Diffusion, right: NDArray[np.float64], found: NDArray[np.float64], paths: MedialPaths
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Straight distances between the medial centres of right and found places, and distances along the body.

    With centres c and c' and the nodes k and l of the paths that are nearest to the two places, the distance
    along the body is ``max(|c - c'|, L_kl - |c - c_k| - |c' - c_l|)``: no shorter than the straight line, and
    else a lower bound (triangle inequality) of a path that leads through the nodes. `L` includes 2 % of the
    way on the surface and the zigzag between nodes around a limb, which is less than the limb's radius.

    Parameters
    ----------
    diffusion
        Medial, of a complete sampling of the rest pose.
    right, found : (n, 3)
        Places on the rest pose.
    paths
        Of `medial_paths`.

    Returns
    -------
    straight, along : (n,) float64
        In the units of the rest pose.
    """
    tree = cKDTree(diffusion.points)
    here, there = (tree.query(each)[1] for each in (right, found))
    return _between(diffusion.centers, paths, here, there)


def mean_medial_distances(
    diffusion: Diffusion, right: NDArray[np.float64], paths: MedialPaths
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Means of `medial_distances` from right places to all of the body: what a random match is off by.

    Parameters
    ----------
    diffusion, right, paths
        As there.

    Returns
    -------
    straight, along : (n,) float64
        In the units of the rest pose.
    """
    here = cKDTree(diffusion.points).query(right)[1]
    everywhere, weights = np.arange(len(diffusion)), diffusion.areas / diffusion.areas.sum()
    means = np.empty((2, len(right)))
    for rows in ranges(len(right), BLOCK):
        block = slice(*rows)
        means[:, block] = [
            each @ weights for each in _between(diffusion.centers, paths, here[block, None], everywhere)
        ]
    return means[0], means[1]


def _between(
    centers: NDArray[np.float64], paths: MedialPaths, here: NDArray[np.int64], there: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """`medial_distances` between samples by their ids, which are broadcast."""
    straight = np.linalg.norm(centers[here] - centers[there], axis=-1)
    to_node = np.linalg.norm(centers - centers[paths.nodes[paths.nearest]], axis=1)
    along = paths.lengths[paths.nearest[here], paths.nearest[there]] - to_node[here] - to_node[there]
    return straight, np.maximum(straight, along)

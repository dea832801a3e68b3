r"""Path lengths through the medial structure of a cloud: what poses and missing data leave alone.

Points are joined to those near both in position and in medial centre (Eq. 9), across gaps where a limb's
far side is there to bridge them, and an edge is as long as the way between the two centres. The shortest
paths then run along the limbs' axes. Between scans of one body with half its surface missing, these lengths
agreed to a few hundredths of sqrt(area), where diffusion times had lost their meaning (lambda_2 ~ 0).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from datasets_gen.compiled import compiled
from datasets_gen.points.farthest import farthest_from_mean, farthest_in_metric
from datasets_gen.points.neighbours import join_parts, neighbour_pairs
from medial.matching.common_units import CloudInUnits, Float, Int

NEIGHBOURS = 10
BRIDGES = 2  # edges that join a part to the next one
SURFACE_SHARE = 0.02  # of the way along the surface, so that points of one medial region differ a little
FAR = 0.3
"""Points with a path between them that is shorter than this, in sqrt(area), do not judge a map."""
CHANGED = 0.15
"""A larger change of a path's length counts as this much: one gap in a scan may lead a path astray."""


@dataclass(frozen=True)
class MedialPaths:
    """Path lengths between K nodes of a cloud.

    Attributes
    ----------
    nodes : (K,) int64
        Point ids, in farthest-point order.
    lengths : (K, K) float64
    radii : (K,) float64
        Medial radii of the nodes.
    nearest : (n,) int64
        Node of every point.
    """

    nodes: Int
    lengths: Float
    radii: Float
    nearest: Int

    @classmethod
    def of(cls, cloud: CloudInUnits, count: int = 700) -> "MedialPaths":
        """Paths of a cloud over `count` nodes."""
        nodes = farthest_from_mean(cloud.points, count)
        features = cloud.features
        tree = cKDTree(features[nodes])
        pairs = join_parts(neighbour_pairs(tree, NEIGHBOURS), cloud.centers[nodes], BRIDGES)
        start, end = nodes[pairs[:, 0]], nodes[pairs[:, 1]]
        along = np.linalg.norm(cloud.centers[start] - cloud.centers[end], axis=1)
        surface = np.linalg.norm(cloud.points[start] - cloud.points[end], axis=1)
        graph = csr_array(
            (along + SURFACE_SHARE * surface + 1e-12, (pairs[:, 0], pairs[:, 1])), shape=(len(nodes),) * 2
        )
        lengths = dijkstra(graph, directed=False)
        return cls(nodes, lengths, cloud.radii[nodes], tree.query(features)[1].astype(np.int64))

    def far_apart(self, count: int) -> Int:
        """Nodes in farthest-point order of the path lengths, from the most remote one, (count,)."""
        remote = int(self.lengths.max(axis=1).argmax())
        return farthest_in_metric(self.lengths.__getitem__, count, remote)[0]

    def outer_half(self) -> NDArray[np.bool_]:
        """Points that lie farther than others along the body from its rest, as limbs and head do, (n,)."""
        mean = self.lengths.mean(axis=1)[self.nearest]
        return np.asarray(mean > np.median(mean))

    def descriptors(self) -> Float:
        """What a node sees: quantiles of its path lengths, and twice its radius, (K, 6)."""
        seen = np.quantile(self.lengths, [0.1, 0.25, 0.5, 0.75, 0.95], axis=1).T
        return np.column_stack([seen, 2 * self.radii])


def path_distortion(source: MedialPaths, target: MedialPaths, points: Int, matches: Int) -> float:
    """How much a map changes path lengths: mean over pairs of points of min(|d_target - d_source|, CHANGED).

    Parameters
    ----------
    source, target
    points, matches : (s,) int64
        Point ids on the source, and where the map takes them on the target.

    Returns
    -------
    float
        In sqrt(area); 0 if no two points are `FAR` from each other.
    """
    return float(
        _mean_change(source.lengths, target.lengths, source.nearest[points], target.nearest[matches])
    )


@compiled()
def _mean_change(before: Float, after: Float, here: Int, there: Int) -> float:
    """The mean over pairs of nodes; path lengths are symmetric."""
    total, far = 0.0, 0
    for a in range(len(here)):
        for b in range(a):
            length = before[here[a], here[b]]
            if length >= FAR:
                total += min(abs(after[there[a], there[b]] - length), CHANGED)
                far += 1
    return total / far if far else 0.0

"""From a quick fit to a dense map: a fine deformation that ends on the surface."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.points.neighbours import query_tree
from medial.matching.common_units import CloudInUnits
from medial.matching.registration.deformation_graph import Attachment, NodeGraph, Pose, moved, moved_centers
from medial.matching.registration.evidence import WEIGHTS, Weights, medial_gap
from medial.matching.registration.fit import Fit
from medial.matching.registration.registration import Registration, Schedule, features, found
from medial.matching.registration.visibility import Visibility

Float = NDArray[np.float64]
Float32 = NDArray[np.float32]
Int = NDArray[np.int64]

FINE_INFLUENCES = 6
"""Nodes that move a point in the fine deformation. Its nodes are close, and more of them make it smoother."""
LOOK_BACK = 3000
"""Number of target points that look for the source in the fine deformation."""
FINE = Schedule(follow=0, rounds=12, stiffness=(1.0, 0.003), unseen=0.05)
"""How the fine deformation settles: softer at the end than the quick one. What the other scan could not have
seen follows its neighbours: pulled to the nearest surface, the front of a limb would end on its back."""
MEETING = 16
"""Number of deformed points around a match that `DenseFit.alone` looks at."""
SAME_NEIGHBOURHOOD = 0.15
"""Points closer than this before the deformation, in sqrt(area), are of one place."""


@dataclass(frozen=True)
class DenseFit:
    """A dense map and how well each point's match holds, from a deformation of either cloud.

    Attributes
    ----------
    match : (n,) int64
        Point of the other cloud.
    found : (n,) float64
        How well the point and its match met, in [0, 1].
    alone : (n,) float64
        Of the deformed points around the match, the share that comes from one place of the body, in [0, 1].
    held : (n,) float64
        How firmly that part of the body still holds on to the rest, in [0, 1] (`NodeGraph.held`).
    """

    match: Int
    found: Float
    alone: Float
    held: Float


class FineDeformation:
    """The fine deformation of a pair, prepared once for several poses.

    Parameters
    ----------
    source, target
        Clouds in common units.
    covers
        Source points that take part, and target points that they look for, in farthest-point order.
    coordinates : (n, d)
        `medial.matching.neighbourhoods` of the source.
    eligible
        Points that may become nodes.
    nodes
        Number of nodes.
    shown, weights
        As for `Registration`.
    """

    def __init__(
        self,
        source: CloudInUnits,
        target: CloudInUnits,
        covers: tuple[Int, Int],
        coordinates: Float32,
        eligible: Int,
        nodes: int,
        shown: tuple[Visibility, Visibility] | None = None,
        weights: Weights = WEIGHTS,
    ) -> None:
        self.source, self.target, self._weights = source, target, weights
        count = max(2, min(nodes, len(source) // 4))
        self.graph, self.attachment = NodeGraph.over(
            coordinates, source.points, eligible, count, FINE_INFLUENCES
        )
        self._taken, among = covers
        self._registration = self._over(self._taken, among, among[:LOOK_BACK], shown)
        everything = np.arange(len(source)), np.arange(len(target)), np.arange(1)
        self._everything = self._over(*everything, None)  # asked for partners alone, not for what is missed

    def _over(
        self, taken: Int, among: Int, look_back: Int, shown: tuple[Visibility, Visibility] | None
    ) -> Registration:
        return Registration.between(
            self.graph,
            self.attachment,
            self.source,
            self.target,
            taken,
            among,
            look_back,
            shown,
            self._weights,
        )

    def adopt(self, graph: NodeGraph, attachment: Attachment, pose: Pose) -> Pose:
        """Carry a pose of coarse nodes over to the fine nodes.

        Parameters
        ----------
        graph
            The coarse nodes.
        attachment
            How all points of the source hang on them.
        pose

        Returns
        -------
        Pose
        """
        taken = self._taken
        points, normals = self.source.points[taken], self.source.normals[taken]
        return self._registration.follow(*moved(points, normals, attachment.rows(taken), graph, pose), FINE)

    def settle(self, pose: Pose) -> Fit:
        """Settle the fine deformation."""
        return self._registration.settle(pose, FINE)

    def judge(self, pose: Pose) -> Fit:
        """The pose as it is."""
        return self._registration.judge(pose)

    def medial_gap(self, fit: Fit) -> float:
        """How far the medial balls of the source, moved with their points, are from the target's."""
        taken, source, target = self._taken, self.source, self.target
        centers = moved_centers(
            source.points[taken], source.centers[taken], self.attachment.rows(taken), self.graph, fit.pose
        )
        return medial_gap(centers, source.radii[taken], target.centers, target.radii)

    def dense(self, fit: Fit) -> DenseFit:
        """The nearest target point, in position and normal, of every deformed source point."""
        final = self._everything.judge(fit.pose)
        deformed = features(*self._everything.moved(fit.pose))
        goals = features(self.target.points[final.partner], self.target.normals[final.partner])
        alone = self._from_one_place(_nearest(deformed, goals), np.arange(len(self.source)))
        return DenseFit(final.partner, final.found, alone, self._held(fit.pose))

    def inverse(self, fit: Fit) -> DenseFit:
        """The nearest deformed source point, in position and normal, of every target point."""
        points, normals = self.target.points, self.target.normals
        here, here_normals = self._everything.moved(fit.pose)
        arrived = _nearest(features(here, here_normals), features(points, normals))
        match = arrived[:, 0]
        met = found(points, normals, here[match], here_normals[match])
        return DenseFit(match, met, self._from_one_place(arrived, match), self._held(fit.pose)[match])

    def _held(self, pose: Pose) -> Float:
        return self.attachment.at_points(self.graph.held(pose))

    def _from_one_place(self, arrived: Int, origin: Int) -> Float:
        """`DenseFit.alone`: where a part without counterpart collapses onto another, both arrive."""
        gap = np.linalg.norm(self.source.points[arrived] - self.source.points[origin][:, None], axis=2)
        return np.asarray((gap < SAME_NEIGHBOURHOOD).mean(axis=1))


def _nearest(places: Float, goals: Float) -> Int:
    """The `MEETING` places nearest to each goal, nearest first; all if there are fewer."""
    count = min(MEETING, len(places))
    near = query_tree(cKDTree(places), goals, k=count)[1]
    return near.reshape(len(goals), count).astype(np.int64)

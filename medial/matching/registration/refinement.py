"""From a rough map to a dense one: spectral refinement, or a fine deformation that ends on the surface."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.compiled import thread_count
from medial.diffusion import Diffusion
from medial.matching.common_units import Cloud
from medial.matching.nearest import nearest
from medial.matching.registration.deformation_graph import Attachment, NodeGraph, Pose, moved
from medial.matching.registration.registration import Fit, Registration, Schedule, features, found

Float = NDArray[np.float64]
Float32 = NDArray[np.float32]
Int = NDArray[np.int64]

FINE_INFLUENCES = 6
"""Nodes that move a point in the fine deformation, whose nodes are close: it is smoother with more."""
LOOK_BACK = 3000
"""Target points that look for the source in the fine deformation."""
FINE = Schedule(follow=0, rounds=12, stiffness=(1.0, 0.003))
MEETING = 16
"""Deformed points around a match that are asked where they come from."""
SAME_NEIGHBOURHOOD = 0.15
"""Points closer than this at rest, in sqrt(area), are no strangers."""
SPECTRAL_MODES = (20, 30, 40, 55, 70, 90, 115, 150)
"""Sizes of the functional maps of spectral refinement."""


@dataclass(frozen=True)
class Dense:
    """A dense map and how well each point's match holds, from a deformation of either cloud.

    Attributes
    ----------
    match : (n,) int64
        Point of the other cloud.
    found : (n,) float64
        How well the point and its match met, in [0, 1].
    alone : (n,) float64
        Of what was deformed and came to lie where they met, the share that came from one place, in [0, 1].
    held : (n,) float64
        How firmly the deformed part of the body still holds on to the rest, in [0, 1].
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
    """

    def __init__(
        self,
        source: Cloud,
        target: Cloud,
        covers: tuple[Int, Int],
        coordinates: Float32,
        eligible: Int,
        nodes: int,
    ) -> None:
        self.source, self.target = source, target
        count = max(2, min(nodes, len(source) // 4))
        self.graph, self.attachment = NodeGraph.over(
            coordinates, source.points, eligible, count, FINE_INFLUENCES
        )
        self._taken, among = covers
        self._registration = self._over(self._taken, among, among[:LOOK_BACK])
        self._everything = self._over(np.arange(len(source)), np.arange(len(target)), np.arange(1))

    def _over(self, taken: Int, among: Int, look_back: Int) -> Registration:
        return Registration.between(
            self.graph, self.attachment, self.source, self.target, taken, among, look_back
        )

    def adopt(self, graph: NodeGraph, attachment: Attachment, pose: Pose) -> Pose:
        """A coarse pose carried over to the fine nodes.

        Parameters
        ----------
        graph
            The coarse nodes.
        attachment
            How all points of the source hang on them.
        pose
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

    def dense(self, fit: Fit) -> Dense:
        """The nearest target point, in position and normal, of every deformed source point."""
        final = self._everything.judge(fit.pose)
        deformed = features(*self._everything.moved(fit.pose))
        goals = features(self.target.points[final.partner], self.target.normals[final.partner])
        alone = self._from_one_place(_nearest(deformed, goals), np.arange(len(self.source)))
        return Dense(final.partner, final.found, alone, self._held(fit.pose))

    def inverse(self, fit: Fit) -> Dense:
        """The nearest deformed source point, in position and normal, of every target point."""
        points, normals = self.target.points, self.target.normals
        here, here_normals = self._everything.moved(fit.pose)
        arrived = _nearest(features(here, here_normals), features(points, normals))
        match = arrived[:, 0]
        met = found(points, normals, here[match], here_normals[match])
        return Dense(match, met, self._from_one_place(arrived, match), self._held(fit.pose)[match])

    def _held(self, pose: Pose) -> Float:
        return self.attachment.at_points(self.graph.held(pose))

    def _from_one_place(self, arrived: Int, origin: Int) -> Float:
        """A part that has no counterpart collapses onto another one: then strangers meet at its matches."""
        gap = np.linalg.norm(self.source.points[arrived] - self.source.points[origin][:, None], axis=2)
        return np.asarray((gap < SAME_NEIGHBOURHOOD).mean(axis=1))


def _nearest(places: Float, goals: Float) -> Int:
    """The `MEETING` places nearest to each goal, nearest first; all if there are fewer."""
    count = min(MEETING, len(places))
    near = cKDTree(places).query(goals, k=count, workers=thread_count())[1]
    return near.reshape(len(goals), count).astype(np.int64)


def spectral_refinement(
    source: Diffusion, target: Diffusion, source_to_target: Int, sizes: tuple[int, ...] = SPECTRAL_MODES
) -> Int:
    """Alternate functional maps and nearest neighbours, with more and more modes (ZoomOut).

    The functional map takes functions on the target to the source by area-weighted projection. A companion
    surface basis, where both clouds have one, refines further.

    Parameters
    ----------
    source, target
    source_to_target : (n_source,) int64
    sizes
        Numbers of modes; larger ones than there are end the refinement.

    Returns
    -------
    (n_source,) int64

    References
    ----------
    Melzi, Ren, Rodolà, Sharma, Wonka, Ovsjanikov: ZoomOut: spectral upsampling for efficient shape
    correspondence. SIGGRAPH Asia 2019.
    """
    modes = min(source.eigenfunctions.shape[1], target.eigenfunctions.shape[1])
    for k in (size for size in sizes if size <= modes):
        here, there = source.eigenfunctions[:, :k], target.eigenfunctions[:, :k]
        functional = (here * source.areas[:, None]).T @ there[source_to_target]  # (k, k): target to source
        source_to_target, _ = nearest(here, there @ functional.T)
    if source.surface is not None and target.surface is not None:
        return spectral_refinement(source.surface, target.surface, source_to_target, sizes)
    return source_to_target

"""Gauss-Newton steps of a deformation graph: collect the pulls on its points, then solve for its nodes."""

import numpy as np
from numpy.typing import NDArray

from medial.matching.registration.deformation_graph import Attachment, NodeGraph, Pose
from medial.matching.registration.energy_terms import add_points, add_pulls
from medial.matching.registration.envelope import solve
from medial.matching.registration.rigid_motions import turned

Float = NDArray[np.float64]
Int = NDArray[np.int64]


class NormalEquations:
    """Gauss-Newton step of a pose: pull the points, then `step`.

    Parameters
    ----------
    graph
    pose
    points : (n, 3)
        At rest.
    attachment
        Of the points.
    """

    def __init__(self, graph: NodeGraph, pose: Pose, points: Float, attachment: Attachment) -> None:
        self._graph, self._pose, self._points, self._attachment = graph, pose, points, attachment
        self._metric, self._force = np.zeros((len(points), 3, 3)), np.zeros((len(points), 3))

    def pull(self, rows: Int, offset: Float, normals: Float, even: Float, along: Float) -> None:
        """Pull some of the points: even |offset|^2 + along (n . offset)^2.

        Parameters
        ----------
        rows : (m,) int64
            The points; they may repeat.
        offset : (m, 3)
            From the goal to where the point is now.
        normals : (m, 3)
            At the goal.
        even, along : (m,)
            Weights.
        """
        add_pulls(self._metric, self._force, rows, offset, normals, even, along)

    def step(self, stiffness: float) -> Pose:
        """The pose after one step, in which neighbouring nodes hold together with a weight."""
        envelope, right = self._graph.envelope, np.zeros(6 * len(self._graph))
        values = envelope.zeros()
        add_points(
            values,
            envelope.origin,
            right,
            self._points,
            self._attachment.nodes,
            self._attachment.weights,
            self._graph.rest,
            self._pose.rotations,
            self._metric,
            self._force,
        )
        self._graph.add_edges(values, right, self._pose, stiffness)
        change = -solve(values, right, envelope).reshape(-1, 6)
        turns, shifts = change[:, :3], change[:, 3:]
        return Pose(turned(self._pose.rotations, turns), self._pose.positions + shifts)

"""Gauss-Newton steps of a deformation graph: collect the pulls on its points, then solve for its nodes."""

import numpy as np
from numpy.typing import NDArray

from medial.matching.registration.banded_cholesky import cholesky_solve
from medial.matching.registration.deformation_graph import Attachment, NodeGraph, Pose
from medial.matching.registration.energy_terms import add_points, add_pulls
from medial.matching.registration.rigid_motions import turned

Float = NDArray[np.float64]
Int = NDArray[np.int64]


def solve(system: Float, right: Float) -> Float:
    """Solution of the (slightly damped) normal equations; only the lower triangle is read."""
    system[np.diag_indices_from(system)] += 1e-6 * np.trace(system) / len(system) + 1e-12
    return -cholesky_solve(system, right)


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
        size = 6 * len(self._graph)
        system, right = np.zeros((size, size)), np.zeros(size)
        turn, nodes, weights = self._pose.rotations, self._attachment.nodes, self._attachment.weights
        add_points(
            system, right, self._points, nodes, weights, self._graph.rest, turn, self._metric, self._force
        )
        self._graph.add_edges(system, right, self._pose, stiffness)
        change = solve(system, right).reshape(-1, 6)
        return Pose(turned(turn, change[:, :3]), self._pose.positions + change[:, 3:])

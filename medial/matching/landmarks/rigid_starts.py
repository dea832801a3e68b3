"""Rigid motions to start from: the principal axes of one cloud on those of the other, in every way.

They need no landmarks, so they help where diffusion has lost its way: much of the surface is missing, and
what is left still has the body's long and short axes. A deformation that is stiff at first and softens little
by little takes it from there, as in nonrigid ICP [ARV07]. The axes turn with the clouds, so the result does
not depend on how the clouds lie in space.

References
----------
[ARV07] Amberg, Romdhani, Vetter: Optimal step nonrigid ICP algorithms for surface registration. CVPR 2007.
"""

from itertools import permutations, product

import numpy as np

from medial.matching.registration.deformation_graph import Float, NodeGraph, Pose

_SIGNS = [np.array(signs) for signs in product((1.0, -1.0), repeat=3)]


def principal_axes(points: Float) -> Float:
    """Principal axes of points (n, 3) as the columns of an orthogonal matrix, (3, 3)."""
    return np.asarray(np.linalg.eigh(np.cov(points.T))[1])


def axis_rotations(source: Float, target: Float) -> Float:
    """The 24 rotations that take orthogonal axes to orthogonal axes, (24, 3, 3).

    Parameters
    ----------
    source, target : (3, 3)
        Axes as columns.
    """
    ways = [target[:, order] * signs @ source.T for order in permutations(range(3)) for signs in _SIGNS]
    return np.array([turn for turn in ways if np.linalg.det(turn) > 0])


def half_turns(axes: Float) -> Float:
    """Rotations by 180 degrees about orthonormal axes (the columns of (3, 3)), (3, 3, 3)."""
    return np.array([2 * np.outer(axis, axis) - np.eye(3) for axis in axes.T])


def rigid_poses(graph: NodeGraph, source: Float, target: Float) -> list[Pose]:
    """Poses that take the middle and the principal axes of one cloud to those of another.

    Parameters
    ----------
    graph
        Nodes over the source.
    source : (n, 3)
    target : (m, 3)
    """
    here, there = source.mean(axis=0), target.mean(axis=0)
    turns = axis_rotations(principal_axes(source), principal_axes(target))
    arms = graph.rest - here
    return [Pose(np.repeat(turn[None], len(graph), axis=0), arms @ turn.T + there) for turn in turns]

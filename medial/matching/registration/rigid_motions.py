"""Rigid motions of nodes: the best ones for given goals, and how rotations change in a step."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled

Float = NDArray[np.float64]
Int = NDArray[np.int64]

LARGEST_TURN = 0.7
"""Largest rotation of a node in one Gauss-Newton step, radians."""


def turned(rotations: Float, vectors: Float) -> Float:
    """Rotations followed by turns (Rodrigues).

    Parameters
    ----------
    rotations : (N, 3, 3)
    vectors : (N, 3)
        Axis times angle; the angle counts as at most `LARGEST_TURN`.

    Returns
    -------
    (N, 3, 3) float64
    """
    angle = np.linalg.norm(vectors, axis=1)
    axis = vectors / np.maximum(angle, 1e-12)[:, None]
    angle = np.minimum(angle, LARGEST_TURN)[:, None, None]
    cross = np.zeros((len(vectors), 3, 3))
    for r in range(3):
        p, q = (r + 1) % 3, (r + 2) % 3
        cross[:, q, p], cross[:, p, q] = axis[:, r], -axis[:, r]
    return (np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)) @ rotations


@compiled()
def local_motions(
    points: Float,
    normals: Float,
    goal: Float,
    goal_normals: Float,
    start: Int,
    near: Int,
    weights: Float,
    rest: Float,
    arm: float,
    smallest: float,
) -> tuple[Float, Float]:
    """Rigid motion of each node that best takes its points, and points `arm` along their normals, to goals.

    Four rounds of weighted Kabsch; weights fall with the residual relative to its median.

    Parameters
    ----------
    points, normals, goal, goal_normals : (n, 3)
    start, near, weights
        Points of node j: ``near[start[j]:start[j + 1]]``, and their weights.
    rest : (N, 3)
    arm, smallest
        Length of the normals, and the smallest scale of residuals.

    Returns
    -------
    rotations : (N, 3, 3)
    positions : (N, 3)
    """
    count = len(rest)
    rotations, positions = np.zeros((count, 3, 3)), np.zeros((count, 3))
    for j in range(count):
        ids, base = near[start[j] : start[j + 1]], weights[start[j] : start[j + 1]]
        x, y = points[ids], goal[ids]
        u, v = arm * normals[ids], arm * goal_normals[ids]
        w = base.copy()
        for _ in range(4):
            _kabsch(rotations[j], positions[j], x, u, y, v, w, rest[j])
            residual = _residuals(rotations[j], positions[j], x, y, rest[j])
            scale = max(np.median(residual), smallest)
            w = base / (1 + (residual / scale) ** 2) ** 2
    return rotations, positions


@compiled()
def _kabsch(
    rotation: Float, position: Float, x: Float, u: Float, y: Float, v: Float, w: Float, rest: Float
) -> None:
    """Write the motion of a node at `rest` that takes x to y and x + u to y + v best, with weights w."""
    total = w.sum() + 1e-300
    cx, cy = np.zeros(3), np.zeros(3)
    for i in range(len(x)):
        share = w[i] / total
        for a in range(3):
            cx[a] += share * (x[i, a] + 0.5 * u[i, a])
            cy[a] += share * (y[i, a] + 0.5 * v[i, a])
    moment = np.zeros((3, 3))
    for i in range(len(x)):
        for a in range(3):
            for b in range(3):
                moment[a, b] += w[i] * (
                    (y[i, a] - cy[a]) * (x[i, b] - cx[b])
                    + (y[i, a] + v[i, a] - cy[a]) * (x[i, b] + u[i, b] - cx[b])
                )
    left, _, right = np.linalg.svd(moment)
    sign = 1.0 if np.linalg.det(left) * np.linalg.det(right) >= 0 else -1.0
    for a in range(3):
        for b in range(3):
            rotation[a, b] = (
                left[a, 0] * right[0, b] + left[a, 1] * right[1, b] + sign * left[a, 2] * right[2, b]
            )
        position[a] = cy[a]
        for b in range(3):
            position[a] += rotation[a, b] * (rest[b] - cx[b])


@compiled()
def _residuals(rotation: Float, position: Float, x: Float, y: Float, rest: Float) -> Float:
    """Distances of moved points from their goals."""
    residual = np.zeros(len(x))
    for i in range(len(x)):
        for a in range(3):
            gap = position[a] - y[i, a]
            for b in range(3):
                gap += rotation[a, b] * (x[i, b] - rest[b])
            residual[i] += gap * gap
    return np.sqrt(residual)

"""Terms of the deformation energy, added to its normal equations: pulls on points, stiffness of edges.

Compiled. A node moves by six numbers: a turn about three axes and a shift. Only the lower triangle of the
system is written. A point's derivative by the motion of node k is the lever L_k = w_k [-[y_k]x, I], (3, 6),
where y_k is the arm from the node to the point and w_k the node's weight.
"""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled

Float = NDArray[np.float64]
Int = NDArray[np.int64]


@compiled()
def add_pulls(
    metric: Float, force: Float, rows: Int, offset: Float, normals: Float, even: Float, along: Float
) -> None:
    """Add the terms even |o|^2 + along (n . o)^2 of offsets o (m, 3) to those of the points they pull.

    A term's metric is M = even I + along n n^T; the points' sums of M, (n, 3, 3), and of M o, (n, 3), are all
    that the normal equations need.
    """
    for i in range(len(rows)):
        j, slip = rows[i], 0.0
        for r in range(3):
            slip += along[i] * normals[i, r] * offset[i, r]
        for r in range(3):
            for c in range(3):
                metric[j, r, c] += along[i] * normals[i, r] * normals[i, c]
            metric[j, r, r] += even[i]
            force[j, r] += even[i] * offset[i, r] + slip * normals[i, r]


@compiled()
def add_points(
    system: Float,
    right: Float,
    points: Float,
    nodes: Int,
    weights: Float,
    rest: Float,
    turn: Float,
    metric: Float,
    force: Float,
) -> None:
    """Add the data terms to the lower triangle of the system and to the right-hand side.

    What is added is L_k^T M L_m and L_k^T f.

    Parameters
    ----------
    system : (6 N, 6 N)
    right : (6 N,)
    points : (n, 3)
        At rest.
    nodes, weights : (n, influences)
        The nodes of each point and their weights.
    rest : (N, 3)
        Nodes at rest.
    turn : (N, 3, 3)
        Rotations of the nodes.
    metric : (n, 3, 3), force : (n, 3)
        From `add_pulls`.
    """
    influences = nodes.shape[1]
    arms, pulled = np.zeros((influences, 3)), np.zeros((3, 6))
    for i in range(len(points)):
        if metric[i, 0, 0] + metric[i, 1, 1] + metric[i, 2, 2] <= 0:
            continue
        for k in range(influences):
            _arm(arms[k], turn[nodes[i, k]], points[i], rest[nodes[i, k]])
        for m in range(influences):
            col, w = 6 * nodes[i, m], weights[i, m]
            _times_lever(pulled, metric[i], arms[m], w)
            _add_force(right[col : col + 6], force[i], arms[m], w)
            for k in range(influences):
                row = 6 * nodes[i, k]
                if row >= col:
                    _add_block(system[row : row + 6, col : col + 6], pulled, arms[k], weights[i, k])


@compiled()
def _times_lever(pulled: Float, metric: Float, y: Float, w: float) -> None:
    """M L for the lever of arm y and weight w, (3, 6)."""
    y0, y1, y2 = y
    for r in range(3):
        u0, u1, u2 = w * metric[r, 0], w * metric[r, 1], w * metric[r, 2]
        pulled[r, 0], pulled[r, 1] = y1 * u2 - y2 * u1, y2 * u0 - y0 * u2
        pulled[r, 2] = y0 * u1 - y1 * u0
        pulled[r, 3], pulled[r, 4], pulled[r, 5] = u0, u1, u2


@compiled()
def _add_force(right: Float, force: Float, y: Float, w: float) -> None:
    """Add L^T f, (6,)."""
    y0, y1, y2 = y
    f0, f1, f2 = w * force[0], w * force[1], w * force[2]
    right[0] += y1 * f2 - y2 * f1
    right[1] += y2 * f0 - y0 * f2
    right[2] += y0 * f1 - y1 * f0
    right[3] += f0
    right[4] += f1
    right[5] += f2


@compiled()
def _add_block(block: Float, pulled: Float, z: Float, v: float) -> None:
    """Add L^T (M L_m) of the lever of arm z and weight v, (6, 6)."""
    z0, z1, z2 = v * z[0], v * z[1], v * z[2]
    for q in range(6):
        p0, p1, p2 = pulled[0, q], pulled[1, q], pulled[2, q]
        block[0, q] += z1 * p2 - z2 * p1
        block[1, q] += z2 * p0 - z0 * p2
        block[2, q] += z0 * p1 - z1 * p0
        block[3, q] += v * p0
        block[4, q] += v * p1
        block[5, q] += v * p2


@compiled()
def add_edges(
    system: Float,
    right: Float,
    edges: Int,
    hold: Float,
    rest: Float,
    turn: Float,
    place: Float,
    reach: float,
    weight: float,
    bend: float,
) -> float:
    """Add the disagreement of neighbours, robustly, and return it (without `weight`).

    An edge with disagreement e counts 2 b^2 (sqrt(1 + (e / b)^2) - 1) for b = `bend`: like e^2 when small,
    linear when large, so that a knee may bend sharply instead of spreading its bend over the leg.

    Parameters
    ----------
    system : (6 N, 6 N)
    right : (6 N,)
    edges : (E, 2)
    hold : (E,)
        Weights of the edges.
    rest, turn, place : (N, 3), (N, 3, 3), (N, 3)
        Nodes at rest, their rotations and positions.
    reach
        Length that turns angles into lengths.
    weight
        Of all edges.
    bend
        b, a length.
    """
    both, gaps = np.zeros((2, 3, 12)), np.zeros((2, 3))
    arm_i, arm_j, axis = np.zeros(3), np.zeros(3), np.zeros(3)
    energy = 0.0
    for e in range(len(edges)):
        i, j = edges[e, 0], edges[e, 1]
        square = _edge_gaps(both, gaps, arm_i, arm_j, rest, turn, place, i, j)
        _relative_turn(axis, turn[i], turn[j])
        for r in range(3):
            square += (reach * axis[r]) ** 2
        root = np.sqrt(1 + square / bend**2)
        energy += hold[e] * 2 * bend**2 * (root - 1)
        s = weight * hold[e] / root
        for end in range(2):
            _add_gap(system, right, both[end], gaps[end], i, j, s)
        _add_turn(system, right, axis, i, j, s * reach * reach)
    return energy


@compiled()
def _edge_gaps(
    both: Float,
    gaps: Float,
    arm_i: Float,
    arm_j: Float,
    rest: Float,
    turn: Float,
    place: Float,
    i: int,
    j: int,
) -> float:
    """Gaps between where nodes i and j take either one's rest place, their derivatives and squared length.

    Writes the gaps (2, 3) and their derivatives by the motions of i and j (2, 3, 12).
    """
    square = 0.0
    for end in range(2):
        x = rest[i] if end == 0 else rest[j]
        _arm(arm_i, turn[i], x, rest[i])
        _arm(arm_j, turn[j], x, rest[j])
        _lever(both[end, :, :6], 1.0, arm_i)
        _lever(both[end, :, 6:], -1.0, arm_j)
        for r in range(3):
            gaps[end, r] = arm_i[r] + place[i, r] - arm_j[r] - place[j, r]
            square += gaps[end, r] ** 2
    return square


@compiled()
def _add_turn(system: Float, right: Float, axis: Float, i: int, j: int, s: float) -> None:
    """Add s |axis|^2, where the axis is that of the turn between i and j."""
    low, high = min(i, j), max(i, j)
    for r in range(3):
        right[6 * i + r] += s * axis[r]
        right[6 * j + r] -= s * axis[r]
        system[6 * i + r, 6 * i + r] += s
        system[6 * j + r, 6 * j + r] += s
        system[6 * high + r, 6 * low + r] -= s


@compiled()
def _add_gap(system: Float, right: Float, both: Float, gap: Float, i: int, j: int, s: float) -> None:
    """Add s |gap|^2, where `both` (3, 12) is the derivative of the gap by the motions of i and j."""
    for p in range(12):
        row = 6 * (i if p < 6 else j) + p % 6
        for r in range(3):
            right[row] += s * both[r, p] * gap[r]
        for q in range(12):
            col = 6 * (i if q < 6 else j) + q % 6
            if row >= col:
                for r in range(3):
                    system[row, col] += s * both[r, p] * both[r, q]


@compiled()
def _lever(block: Float, w: float, y: Float) -> None:
    """Derivative of a point at arm y from its node by the node's turn and shift: w [-[y]x, I], (3, 6)."""
    block[:] = 0.0
    block[0, 1], block[0, 2] = w * y[2], -w * y[1]
    block[1, 0], block[1, 2] = -w * y[2], w * y[0]
    block[2, 0], block[2, 1] = w * y[1], -w * y[0]
    for r in range(3):
        block[r, 3 + r] = w


@compiled()
def _arm(out: Float, turn: Float, x: Float, g: Float) -> None:
    """R (x - g)."""
    for r in range(3):
        out[r] = turn[r, 0] * (x[0] - g[0]) + turn[r, 1] * (x[1] - g[1]) + turn[r, 2] * (x[2] - g[2])


@compiled()
def _relative_turn(axis: Float, a: Float, b: Float) -> None:
    """Axis times angle of a b^T."""
    trace = 0.0
    for r in range(3):
        for c in range(3):
            trace += a[r, c] * b[r, c]
    angle = np.arccos(min(1.0, max(-1.0, 0.5 * (trace - 1))))
    sine = np.sin(angle)
    if angle > 3.14159:  # half a turn: every column of a b^T + 1 has the direction of the axis
        longest = 0.0
        for k in range(3):
            column = np.zeros(3)
            for r in range(3):
                column[r] = 1.0 if r == k else 0.0
                for c in range(3):
                    column[r] += a[r, c] * b[k, c]
            length = np.sqrt((column**2).sum())
            if length > longest:
                longest = length
                axis[:] = column * (angle / length)
        return
    factor = 0.5 * (angle / sine if sine > 1e-6 else 1.0)
    for r in range(3):
        p, q = (r + 1) % 3, (r + 2) % 3
        value = 0.0
        for c in range(3):
            value += a[q, c] * b[p, c] - a[p, c] * b[q, c]
        axis[r] = factor * value

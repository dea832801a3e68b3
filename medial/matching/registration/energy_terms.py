"""Terms of the deformation energy, added to its normal equations: pulls on points, stiffness of edges.

A node moves by six numbers: a turn about three axes and a shift. Of the system the lower triangle is kept, in
the blocks of an `envelope.Envelope`. A point's derivative by the motion of node k is the lever
L_k = w_k [-[y_k]x, I], (3, 6), where y_k is the arm from the node to the point and w_k its weight.
"""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled
from medial.matching.registration.envelope import BLOCK, HEIGHT

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
    values: Float,
    origin: Int,
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
    values, origin
        Of the system, and where its rows are (`envelope.Envelope`).
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
                if nodes[i, k] >= nodes[i, m]:
                    _add_block(values, origin[nodes[i, k]] + HEIGHT * col, pulled, arms[k], weights[i, k])


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
def _add_block(values: Float, at: int, pulled: Float, z: Float, v: float) -> None:
    """Add L^T (M L_m) of the lever of arm z and weight v, (6, 6), to the block that starts there."""
    z0, z1, z2 = v * z[0], v * z[1], v * z[2]
    for q in range(6):
        p0, p1, p2 = pulled[0, q], pulled[1, q], pulled[2, q]
        values[at] += z1 * p2 - z2 * p1
        values[at + 1] += z2 * p0 - z0 * p2
        values[at + 2] += z0 * p1 - z1 * p0
        values[at + 3] += v * p0
        values[at + 4] += v * p1
        values[at + 5] += v * p2
        at += HEIGHT


@compiled()
def strain_of_edges(
    edges: Int, hold: Float, rest: Float, turn: Float, place: Float, reach: float, bend: float
) -> float:
    """Disagreement of neighbours, weighted.

    An edge with disagreement e counts 2 b^2 (sqrt(1 + (e / b)^2) - 1) for b = `bend`: like e^2 when small,
    linear when large, so that a knee may bend sharply instead of spreading its bend over the leg.

    Parameters
    ----------
    edges : (E, 2)
    hold : (E,)
        Weights of the edges.
    rest, turn, place : (N, 3), (N, 3, 3), (N, 3)
        Nodes at rest, their rotations and positions.
    reach, bend
        The length that turns angles into lengths, and b.
    """
    gaps, arms, axis, strain = np.zeros((2, 3)), np.zeros((2, 2, 3)), np.zeros(3), 0.0
    for e in range(len(edges)):
        square = _disagreement(gaps, arms, axis, edges[e, 0], edges[e, 1], rest, turn, place, reach)
        strain += hold[e] * 2 * bend**2 * (np.sqrt(1 + square / bend**2) - 1)
    return strain


@compiled()
def add_edges(
    values: Float,
    origin: Int,
    right: Float,
    edges: Int,
    hold: Float,
    rest: Float,
    turn: Float,
    place: Float,
    reach: float,
    weight: float,
    bend: float,
) -> None:
    """Add `weight` times the strain to the system and to the right-hand side.

    Parameters
    ----------
    values, origin
        Of the system, and where its rows are (`envelope.Envelope`).
    right : (6 N,)
    edges, hold, rest, turn, place, reach, bend
        As for `strain_of_edges`.
    weight
        Of all edges.
    """
    gaps, arms, axis, both = np.zeros((2, 3)), np.zeros((2, 2, 3)), np.zeros(3), np.zeros((3, 12))
    for e in range(len(edges)):
        i, j = edges[e, 0], edges[e, 1]
        square = _disagreement(gaps, arms, axis, i, j, rest, turn, place, reach)
        s = weight * hold[e] / np.sqrt(1 + square / bend**2)
        for end in range(2):
            _lever(both[:, :6], 1.0, arms[end, 0])
            _lever(both[:, 6:], -1.0, arms[end, 1])
            _add_gap(values, origin, right, both, gaps[end], i, j, s)
        _add_turn(values, origin, right, axis, i, j, s * reach * reach)


@compiled()
def _disagreement(
    gaps: Float,
    arms: Float,
    axis: Float,
    i: int,
    j: int,
    rest: Float,
    turn: Float,
    place: Float,
    reach: float,
) -> float:
    """Squared disagreement of nodes i and j: on where either one's rest place goes, and on how they turn.

    Writes the gaps between where i and j take the two places, (2, 3), the arms from i and from j, (2, 2, 3),
    and the axis times angle of the turn between them.
    """
    square = 0.0
    for end in range(2):
        x = rest[i] if end == 0 else rest[j]
        _arm(arms[end, 0], turn[i], x, rest[i])
        _arm(arms[end, 1], turn[j], x, rest[j])
        for r in range(3):
            gaps[end, r] = arms[end, 0, r] + place[i, r] - arms[end, 1, r] - place[j, r]
            square += gaps[end, r] ** 2
    _relative_turn(axis, turn[i], turn[j])
    for r in range(3):
        square += (reach * axis[r]) ** 2
    return square


@compiled()
def _add_turn(values: Float, origin: Int, right: Float, axis: Float, i: int, j: int, s: float) -> None:
    """Add s |axis|^2, where the axis is that of the turn between i and j."""
    low, high = min(i, j), max(i, j)
    for r in range(3):
        right[6 * i + r] += s * axis[r]
        right[6 * j + r] -= s * axis[r]
        values[origin[i] + BLOCK * i + (HEIGHT + 1) * r] += s
        values[origin[j] + BLOCK * j + (HEIGHT + 1) * r] += s
        values[origin[high] + BLOCK * low + (HEIGHT + 1) * r] -= s


@compiled()
def _add_gap(
    values: Float, origin: Int, right: Float, both: Float, gap: Float, i: int, j: int, s: float
) -> None:
    """Add s |gap|^2, where `both` (3, 12) is the derivative of the gap by the motions of i and j."""
    for p in range(12):
        for r in range(3):
            right[6 * (i if p < 6 else j) + p % 6] += s * both[r, p] * gap[r]
    for a in range(2):
        for b in range(2):
            row, col = i if a == 0 else j, i if b == 0 else j
            if row < col:
                continue
            for q in range(6):
                at = origin[row] + BLOCK * col + HEIGHT * q
                for p in range(6):
                    for r in range(3):
                        values[at + p] += s * both[r, 6 * a + p] * both[r, 6 * b + q]


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

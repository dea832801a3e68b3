"""Compiled inner loops of the deformation graph: blending, the normal equations, paths between nodes."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled

Float = NDArray[np.float64]
Int = NDArray[np.int64]

LARGEST_TURN = 0.7
"""Largest rotation of a node in one Gauss-Newton step, radians."""


@compiled(fastmath={"contract"})
def moved(
    points: Float, directions: Float, nodes: Int, weights: Float, rest: Float, turn: Float, place: Float
) -> tuple[Float, Float]:
    """Blended positions and unit directions, (n, 3) each."""
    n, influences = nodes.shape
    here, normal = np.zeros((n, 3)), np.zeros((n, 3))
    for i in range(n):
        for k in range(influences):
            j, w = nodes[i, k], weights[i, k]
            for r in range(3):
                x, v = place[j, r], 0.0
                for c in range(3):
                    x += turn[j, r, c] * (points[i, c] - rest[j, c])
                    v += turn[j, r, c] * directions[i, c]
                here[i, r] += w * x
                normal[i, r] += w * v
        length = np.sqrt(normal[i, 0] ** 2 + normal[i, 1] ** 2 + normal[i, 2] ** 2) + 1e-12
        for r in range(3):
            normal[i, r] /= length
    return here, normal


@compiled(fastmath={"contract"})
def _lever(block: Float, w: float, y: Float) -> None:
    """Derivative of a point at arm y from its node by the node's turn and shift: w [-[y]x, I], (3, 6)."""
    block[:] = 0.0
    block[0, 1], block[0, 2] = w * y[2], -w * y[1]
    block[1, 0], block[1, 2] = -w * y[2], w * y[0]
    block[2, 0], block[2, 1] = w * y[1], -w * y[0]
    for r in range(3):
        block[r, 3 + r] = w


@compiled(fastmath={"contract"})
def _arm(out: Float, turn: Float, x: Float, g: Float) -> None:
    """R (x - g)."""
    for r in range(3):
        out[r] = turn[r, 0] * (x[0] - g[0]) + turn[r, 1] * (x[1] - g[1]) + turn[r, 2] * (x[2] - g[2])


@compiled(fastmath={"contract"})
def meeting(points: Float, normals: Float, goals: Float, goal_normals: Float) -> tuple[Float, Float]:
    """Squared distances of points from their goals, and cosines of their normals, not below 0; (n,) each."""
    square, cosine = np.zeros(len(points)), np.zeros(len(points))
    for i in range(len(points)):
        dot = 0.0
        for r in range(3):
            square[i] += (points[i, r] - goals[i, r]) ** 2
            dot += normals[i, r] * goal_normals[i, r]
        cosine[i] = min(1.0, max(0.0, dot))
    return square, cosine


@compiled(fastmath={"contract"})
def nearest_of_few(places: Float, goals: Float) -> Int:
    """Index of the place nearest to each goal, (g,); of equally near ones the first.

    Compares all pairs: for some hundred places faster than making a tree. The innermost loop runs over the
    goals, side by side.

    Parameters
    ----------
    places : (p, 6)
    goals : (g, 6)
    """
    a, b, c, d, e, f = [np.ascontiguousarray(goals[:, k]) for k in range(6)]
    index, least = np.zeros(len(goals), np.int64), np.full(len(goals), np.inf)
    for i in range(len(places)):
        u, v, w, x, y, z = places[i]
        for j in range(len(goals)):
            square = (a[j] - u) ** 2 + (b[j] - v) ** 2 + (c[j] - w) ** 2
            square += (d[j] - x) ** 2 + (e[j] - y) ** 2 + (f[j] - z) ** 2
            nearer = square < least[j]
            least[j] = square if nearer else least[j]
            index[j] = i if nearer else index[j]
    return index


@compiled(fastmath={"contract"})
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


@compiled(fastmath={"contract"})
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

    A point's derivative by node k is L_k = w_k [-[y_k]x, I], y_k its arm from that node; what is added is
    L_k^T M L_m and L_k^T f, with the cross products written out.
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
            y0, y1, y2 = arms[m]
            for r in range(3):  # M L_m
                u0, u1, u2 = w * metric[i, r, 0], w * metric[i, r, 1], w * metric[i, r, 2]
                pulled[r, 0], pulled[r, 1] = y1 * u2 - y2 * u1, y2 * u0 - y0 * u2
                pulled[r, 2] = y0 * u1 - y1 * u0
                pulled[r, 3], pulled[r, 4], pulled[r, 5] = u0, u1, u2
            f0, f1, f2 = w * force[i, 0], w * force[i, 1], w * force[i, 2]
            right[col] += y1 * f2 - y2 * f1
            right[col + 1] += y2 * f0 - y0 * f2
            right[col + 2] += y0 * f1 - y1 * f0
            right[col + 3] += f0
            right[col + 4] += f1
            right[col + 5] += f2
            for k in range(influences):
                row, v = 6 * nodes[i, k], weights[i, k]
                if row < col:
                    continue
                z0, z1, z2 = v * arms[k, 0], v * arms[k, 1], v * arms[k, 2]
                for q in range(6):
                    p0, p1, p2 = pulled[0, q], pulled[1, q], pulled[2, q]
                    system[row, col + q] += z1 * p2 - z2 * p1
                    system[row + 1, col + q] += z2 * p0 - z0 * p2
                    system[row + 2, col + q] += z0 * p1 - z1 * p0
                    system[row + 3, col + q] += v * p0
                    system[row + 4, col + q] += v * p1
                    system[row + 5, col + q] += v * p2


@compiled(fastmath={"contract"})
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
    """
    both, gaps = np.zeros((2, 3, 12)), np.zeros((2, 3))
    arm_i, arm_j, axis = np.zeros(3), np.zeros(3), np.zeros(3)
    energy = 0.0
    for e in range(len(edges)):
        i, j = edges[e, 0], edges[e, 1]
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
        _relative_turn(axis, turn[i], turn[j])
        for r in range(3):
            square += (reach * axis[r]) ** 2
        root = np.sqrt(1 + square / bend**2)
        energy += hold[e] * 2 * bend**2 * (root - 1)
        s = weight * hold[e] / root
        for end in range(2):
            _add_gap(system, right, both[end], gaps[end], i, j, s)
        low, high = min(i, j), max(i, j)
        for r in range(3):
            lean = s * reach * reach
            right[6 * i + r] += lean * axis[r]
            right[6 * j + r] -= lean * axis[r]
            system[6 * i + r, 6 * i + r] += lean
            system[6 * j + r, 6 * j + r] += lean
            system[6 * high + r, 6 * low + r] -= lean
    return energy


@compiled(fastmath={"contract"})
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


def turned(rotations: Float, vectors: Float) -> Float:
    """Rotations followed by turns about axis times angle (Rodrigues), the angle capped."""
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
            total = w.sum() + 1e-300
            cx, cy = np.zeros(3), np.zeros(3)
            for i in range(len(ids)):
                cx += w[i] / total * (x[i] + 0.5 * u[i])
                cy += w[i] / total * (y[i] + 0.5 * v[i])
            moment = np.zeros((3, 3))
            for i in range(len(ids)):
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
                    rotations[j, a, b] = (
                        left[a, 0] * right[0, b] + left[a, 1] * right[1, b] + sign * left[a, 2] * right[2, b]
                    )
                positions[j, a] = cy[a]
                for b in range(3):
                    positions[j, a] += rotations[j, a, b] * (rest[j, b] - cx[b])
            residual = np.zeros(len(ids))
            for i in range(len(ids)):
                for a in range(3):
                    gap = positions[j, a] - y[i, a]
                    for b in range(3):
                        gap += rotations[j, a, b] * (x[i, b] - rest[j, b])
                    residual[i] += gap * gap
            residual = np.sqrt(residual)
            scale = max(np.median(residual), smallest)
            w = base / (1 + (residual / scale) ** 2) ** 2
    return rotations, positions


@compiled(fastmath={"contract", "reassoc"})
def _dot(a: Float, b: Float) -> float:
    total = 0.0
    for k in range(len(a)):
        total += a[k] * b[k]
    return total


@compiled(fastmath={"contract"})
def cholesky_solve(system: Float, right: Float) -> Float:
    """Solution of a positive definite system of which the lower triangle is given; it is overwritten.

    A row of the factor starts where that of the system does, so that the cost grows with the square of the
    bandwidth, not of the size: nodes are numbered along the body.
    """
    first, x = np.zeros(len(right), np.int64), right.copy()
    for i in range(len(right)):
        row, start = system[i], 0
        while start < i and row[start] == 0:
            start += 1
        first[i] = start
        for j in range(start, i):
            common = max(start, first[j])
            row[j] = (row[j] - _dot(row[common:j], system[j, common:j])) / system[j, j]
        row[i] = np.sqrt(row[i] - _dot(row[start:i], row[start:i]))
        x[i] = (x[i] - _dot(row[start:i], x[start:i])) / row[i]
    for i in range(len(right) - 1, -1, -1):
        x[i] /= system[i, i]
        for k in range(first[i], i):
            x[k] -= system[i, k] * x[i]
    return x


@compiled()
def strongest_paths(count: int, edges: Int, strength: Float) -> Float:
    """Strength of the best path between any two nodes, (N, N): that of its weakest edge; 1 to itself.

    Trees grow by edges, the strongest first: the one that joins two of them is the weakest on the best path
    from any node of the one to any of the other.

    Parameters
    ----------
    count
        N.
    edges : (E, 2)
    strength : (E,)
        In [0, 1].
    """
    best, tree = np.zeros((count, count)), np.arange(count)
    for k in range(count):
        best[k, k] = 1.0
    for e in np.argsort(-strength):
        here, there = tree[edges[e, 0]], tree[edges[e, 1]]
        if here == there:
            continue
        first, second = np.flatnonzero(tree == here), np.flatnonzero(tree == there)
        for i in first:
            for j in second:
                best[i, j] = best[j, i] = strength[e]
        tree[second] = here
    return best

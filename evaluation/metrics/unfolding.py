"""Straight lines over a few unfolded triangles: the short exact geodesics that longer ones are made of.

A strip of triangles is laid flat in the plane of its first one, with the starting point at the origin. A
corner of the strip that is seen through all the edges crossed so far lies at its exact straight-line
distance.
"""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled
from datasets_gen.records import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.integer]

DEPTH = 5
"""Edges that a straight line between vertices may cross: every vertex gets some 50 neighbours."""

ENTRY_DEPTH = 6
"""Edges that a straight line from or to a point inside a face may cross."""

REACHED = 3 + 3 * (2**ENTRY_DEPTH - 1)
"""Most vertices one unfolding can reach."""

_EPS = 1e-12


def face_adjacency(faces: NDArray[np.integer]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Neighbours across edges of an oriented manifold.

    Edge k of a face lies opposite its corner k.

    Parameters
    ----------
    faces : (f, 3)

    Returns
    -------
    neighbour : (f, 3) int32
        Face on the other side of each edge, -1 at a boundary.
    opposite : (f, 3) int32
        Local index, in that face, of its corner opposite the edge.

    Raises
    ------
    InputError
        If an edge has more than two faces or its faces disagree about orientation.
    """
    f = len(faces)
    tails = faces[:, [1, 2, 0]].astype(np.int64).ravel()
    heads = faces[:, [2, 0, 1]].astype(np.int64).ravel()
    count = int(faces.max()) + 1
    forward, backward = tails * count + heads, heads * count + tails
    order = np.argsort(forward)
    if (np.diff(forward[order]) == 0).any():
        raise InputError("the mesh has an edge with more than two faces or mixed orientation; repair it")
    position = np.searchsorted(forward[order], backward).clip(max=3 * f - 1)
    twin = order[position]
    found = forward[twin] == backward
    neighbour = np.where(found, twin // 3, -1).reshape(f, 3).astype(np.int32)
    opposite = np.where(found, twin % 3, 0).reshape(f, 3).astype(np.int32)
    return neighbour, opposite


@compiled()
def third_corner(
    rx: float, ry: float, lx: float, ly: float, to_right: float, to_left: float
) -> tuple[float, float]:
    """Lay the next triangle's far corner flat; its edge runs from right to left, seen from the origin."""
    ex, ey = lx - rx, ly - ry
    length = np.sqrt(ex * ex + ey * ey) + 1e-300
    along = (to_right * to_right - to_left * to_left + length * length) / (2 * length)
    away = np.sqrt(max(to_right * to_right - along * along, 0.0))
    ex, ey = ex / length, ey / length
    return rx + along * ex + away * ey, ry + along * ey - away * ex


@compiled()
def _length(vertices: Floats, i: int, j: int) -> float:
    dx = vertices[i, 0] - vertices[j, 0]
    dy = vertices[i, 1] - vertices[j, 1]
    dz = vertices[i, 2] - vertices[j, 2]
    return np.sqrt(dx * dx + dy * dy + dz * dz)


@compiled()
def lay_flat(vertices: Floats, a: int, b: int, c: int, point: Floats) -> Floats:
    """Corners of a triangle in its own plane with `point` at the origin, counter-clockwise, (3, 2)."""
    u, v = vertices[b] - vertices[a], vertices[c] - vertices[a]
    ex = u / (np.sqrt((u * u).sum()) + 1e-300)
    w = v - ex * (v * ex).sum()
    ey = w / (np.sqrt((w * w).sum()) + 1e-300)
    flat = np.empty((3, 2))
    for k, corner in enumerate((a, b, c)):
        offset = vertices[corner] - point
        flat[k, 0] = (offset * ex).sum()
        flat[k, 1] = (offset * ey).sum()
    return flat


@compiled()
def see_through(
    vertices: Floats,
    faces: Ints,
    neighbour: Ints,
    opposite: Ints,
    face: int,
    edge: int,
    flat: Floats,
    goal_face: int,
    goal: Floats,
    ids: Ints,
    lengths: Floats,
    used: int,
    deepest: int,
) -> tuple[int, float]:
    """Visit what is seen from the origin through one edge of a flat triangle, some triangles on.

    Parameters
    ----------
    vertices, faces, neighbour, opposite
        The mesh and its `face_adjacency`.
    face, edge
        The triangle that holds the origin, and which of its edges to look through.
    flat : (3, 2)
        That triangle laid flat.
    goal_face, goal
        A point of the surface (face id, barycentrics): its distance is returned if it is seen. -1: none.
    ids, lengths, used
        Buffers of vertices seen and their distances, filled from `used` on.
    deepest
        Edges to look through.

    Returns
    -------
    used : int
    direct : float
        Distance of the goal, or infinity.
    """
    stack_face = np.empty(deepest + 2, np.int64)
    stack_edge = np.empty(deepest + 2, np.int64)
    stack_depth = np.empty(deepest + 2, np.int64)
    # edge ends (right, left), then the cone seen through all the edges so far (right, left)
    stack = np.empty((deepest + 2, 8))
    r, left = flat[(edge + 1) % 3], flat[(edge + 2) % 3]
    stack_face[0], stack_edge[0], stack_depth[0] = face, edge, 1
    stack[0, 0:2], stack[0, 2:4], stack[0, 4:6], stack[0, 6:8] = r, left, r, left
    top = 1
    direct = np.inf
    while top > 0:
        top -= 1
        f, e, depth = stack_face[top], stack_edge[top], stack_depth[top]
        g = neighbour[f, e]
        if g < 0:
            continue
        rx, ry, lx, ly, ax, ay, bx, by = stack[top]
        o = opposite[f, e]
        w, wl, wr = faces[g, o], faces[g, (o + 1) % 3], faces[g, (o + 2) % 3]
        x, y = third_corner(rx, ry, lx, ly, _length(vertices, w, wr), _length(vertices, w, wl))
        slack = _EPS * (x * x + y * y + rx * rx + ry * ry)
        right_of_left = x * by - y * bx >= -slack  # w is clockwise of the cone's left side
        left_of_right = ax * y - ay * x >= -slack
        if right_of_left and left_of_right:
            ids[used], lengths[used] = w, np.sqrt(x * x + y * y)
            used += 1
        if g == goal_face:
            px = goal[o] * x + goal[(o + 1) % 3] * lx + goal[(o + 2) % 3] * rx
            py = goal[o] * y + goal[(o + 1) % 3] * ly + goal[(o + 2) % 3] * ry
            if px * by - py * bx >= -slack and ax * py - ay * px >= -slack:
                direct = min(direct, np.sqrt(px * px + py * py))
        if depth == deepest:
            continue
        if left_of_right:  # something is seen through the edge from the right end to w
            stack_face[top], stack_edge[top], stack_depth[top] = g, (o + 1) % 3, depth + 1
            stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = rx, ry, x, y
            stack[top, 4], stack[top, 5] = ax, ay
            if right_of_left:
                stack[top, 6], stack[top, 7] = x, y
            else:
                stack[top, 6], stack[top, 7] = bx, by
            top += 1
        if right_of_left:
            stack_face[top], stack_edge[top], stack_depth[top] = g, (o + 2) % 3, depth + 1
            stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = x, y, lx, ly
            if left_of_right:
                stack[top, 4], stack[top, 5] = x, y
            else:
                stack[top, 4], stack[top, 5] = ax, ay
            stack[top, 6], stack[top, 7] = bx, by
            top += 1
    return used, direct


@compiled()
def enter(
    vertices: Floats,
    faces: Ints,
    neighbour: Ints,
    opposite: Ints,
    face: int,
    weights: Floats,
    goal_face: int,
    goal: Floats,
    ids: Ints,
    lengths: Floats,
) -> tuple[int, float]:
    """Vertices that a point of the surface sees, how many they are, and its distance to a goal it sees."""
    a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
    point = weights[0] * vertices[a] + weights[1] * vertices[b] + weights[2] * vertices[c]
    flat = lay_flat(vertices, a, b, c, point)
    direct = np.inf
    if face == goal_face:
        x = (goal * flat[:, 0]).sum()
        y = (goal * flat[:, 1]).sum()
        direct = np.sqrt(x * x + y * y)
    used = 0
    for k in range(3):
        ids[used] = faces[face, k]
        lengths[used] = np.sqrt(flat[k, 0] ** 2 + flat[k, 1] ** 2)
        used += 1
    for edge in range(3):
        used, seen = see_through(
            vertices,
            faces,
            neighbour,
            opposite,
            face,
            edge,
            flat,
            goal_face,
            goal,
            ids,
            lengths,
            used,
            ENTRY_DEPTH,
        )
        direct = min(direct, seen)
    return used, direct


@compiled()
def shortcuts(vertices: Floats, faces: Ints, neighbour: Ints, opposite: Ints) -> tuple[Ints, Ints, Floats]:
    """All straight lines between vertices over up to `DEPTH` edges, plus the mesh edges themselves.

    Returns
    -------
    rows, cols : (m,) int64
    lengths : (m,) float64
        Pairs may repeat.
    """
    per_corner = 1 + (2**DEPTH - 1)
    size = 3 * len(faces) * per_corner
    rows, cols, lengths = np.empty(size, np.int64), np.empty(size, np.int64), np.empty(size)
    ids, found = np.empty(REACHED, np.int64), np.empty(REACHED)
    nowhere = np.zeros(3)
    n = 0
    for f in range(len(faces)):
        for k in range(3):
            v = faces[f, k]
            flat = lay_flat(vertices, faces[f, 0], faces[f, 1], faces[f, 2], vertices[v])
            used, _ = see_through(
                vertices, faces, neighbour, opposite, f, k, flat, -1, nowhere, ids, found, 0, DEPTH
            )
            following = faces[f, (k + 1) % 3]
            rows[n], cols[n], lengths[n] = v, following, _length(vertices, v, following)
            n += 1
            for i in range(used):
                rows[n], cols[n], lengths[n] = v, ids[i], found[i]
                n += 1
    return rows[:n], cols[:n], lengths[:n]

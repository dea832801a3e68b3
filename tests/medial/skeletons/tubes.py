"""Oriented clouds around known centre lines."""

import numpy as np

from tests.medial.clouds import thinned

RADIUS = 0.3
ARMS = np.array([[0, -2.0, 0], [1.5, 1.5, 0], [-1.6, 1.3, 0.5]])


class Tube:
    """Points, normals and the centre line, as densely sampled places."""

    def __init__(self, points, normals, line):
        self.points, self.normals, self.line = points, normals, line

    def facing(self, direction):
        """What of the surface faces a direction: half of it, on one side."""
        kept = self.normals @ np.asarray(direction, float) > 0
        return Tube(self.points[kept], self.normals[kept], self.line)

    def moved(self, turn, scale, shift):
        return Tube(
            scale * self.points @ turn.T + shift, self.normals @ turn.T, scale * self.line @ turn.T + shift
        )


def swept(line, n, radius=RADIUS, seed=0):
    """Surface at a distance from a smooth line (m, 3), without caps."""
    random = np.random.default_rng(seed)
    tangent = np.gradient(line, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side = np.cross(tangent, [0.3, 0.2, 0.9])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(tangent, side)
    at, turn = random.integers(len(line), size=12 * n), random.uniform(0, 2 * np.pi, 12 * n)
    normals = np.cos(turn)[:, None] * side[at] + np.sin(turn)[:, None] * other[at]
    return Tube(*thinned(line[at] + radius * normals, normals, n), line)


def straight(n=700):
    return swept(np.linspace([0, -1.5, 0], [0, 1.5, 0], 2000), n)


def bent(n=900):
    """Half a circle of radius 1.2."""
    turn = np.linspace(0, np.pi, 2000)
    return swept(1.2 * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn]), n)


def forked(n=1200):
    """Three tubes that meet in a point: a Y in space. Normals are those of the tubes, to the seam."""
    parts = [swept(np.linspace([0, 0, 0], end, 1500), n, seed=k) for k, end in enumerate(ARMS)]
    points, normals = [], []
    for k, part in enumerate(parts):
        outside = np.ones(len(part.points), bool)
        for m, end in enumerate(ARMS):
            if m != k:
                share = np.clip(part.points @ end / (end @ end), 0, 1)
                outside &= np.linalg.norm(part.points - share[:, None] * end, axis=1) > RADIUS
        points.append(part.points[outside])
        normals.append(part.normals[outside])
    line = np.concatenate([part.line for part in parts])
    return Tube(*thinned(np.concatenate(points), np.concatenate(normals), n), line)


def ring(n=2000):
    turn = np.linspace(0, 2 * np.pi, 4001)[:-1]
    line = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    closed = swept(np.concatenate([line, line[:1]]), n)
    return Tube(closed.points, closed.normals, line)

"""How sound posed meshes are: faces that pass through each other, and edges that poses stretch."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.meshes.geometry import undirected_edges
from datasets_gen.shape import Shape

Array = NDArray[np.float64]


def crossing_faces(shape: Shape) -> NDArray[np.bool_]:
    """Faces that an edge of a face without common vertices passes through, and the faces of such edges.

    Exact but for rounding; candidates are pairs of faces whose bounding spheres meet. Faces of one plane and
    faces that merely touch do not count.

    Parameters
    ----------
    shape

    Returns
    -------
    (f,) bool
    """
    corners = shape.vertices[shape.faces]
    pairs = _near_pairs(corners)
    a, b = shape.faces[pairs[:, 0]], shape.faces[pairs[:, 1]]
    apart = ~(a[:, :, None] == b[:, None, :]).any(axis=(1, 2))
    pairs = pairs[apart]
    hit = np.zeros(len(pairs), dtype=bool)
    for first, second in (pairs.T, pairs[:, ::-1].T):
        for k in range(3):
            hit |= _passes(corners[first, k], corners[first, k - 1], corners[second])
    crossed = np.zeros(len(shape.faces), dtype=bool)
    crossed[pairs[hit]] = True
    return crossed


def _near_pairs(corners: Array) -> NDArray[np.int64]:
    """Pairs of triangles (f, 3, 3) whose bounding spheres and boxes meet, (n, 2).

    Triangles are searched with those of about their size or smaller, so that a few large ones do not make
    candidates of all.
    """
    centres = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    low, high = corners.min(axis=1), corners.max(axis=1)
    order = np.argsort(radii, kind="stable")
    found = []
    for start in range(0, len(order), 4096):
        large, tree = order[start : start + 4096], cKDTree(centres[order[: start + 4096]])
        lists = tree.query_ball_point(centres[large], radii[large] + radii[large].max())
        first = np.repeat(large, [len(each) for each in lists])
        second = order[np.concatenate([np.asarray(each, dtype=np.int64) for each in lists])]
        near = (low[first] <= high[second]).all(axis=1) & (low[second] <= high[first]).all(axis=1)
        found.append(np.sort(np.stack([first[near], second[near]], axis=1), axis=1))
    pairs = np.unique(np.concatenate(found), axis=0)
    return pairs[pairs[:, 0] < pairs[:, 1]]


def _passes(start: Array, end: Array, triangles: Array) -> NDArray[np.bool_]:
    """Whether segments (n, 3) pass through triangles (n, 3, 3)."""

    def volume(p: Array, q: Array, r: Array, s: Array) -> Array:
        return np.asarray(np.einsum("nd,nd->n", np.cross(q - p, r - p), s - p))

    a, b, c = (triangles[:, k] for k in range(3))
    sides = volume(a, b, c, start) * volume(a, b, c, end) < 0
    ab, bc, ca = volume(start, end, a, b), volume(start, end, b, c), volume(start, end, c, a)
    return sides & (((ab > 0) & (bc > 0) & (ca > 0)) | ((ab < 0) & (bc < 0) & (ca < 0)))


class Stretch(NamedTuple):
    """Lengths of the edges of a pose over those of another."""

    shortest: float
    longest: float
    low: float
    """99 % of the edges lie between `low` and `high`."""
    high: float

    @property
    def line(self) -> str:
        """For people: ``edges x 0.61 to 1.72, 99 % of them 0.84 to 1.15``."""
        every, most = (f"{a:.2f} to {b:.2f}" for a, b in (self[:2], self[2:]))
        return f"edges x {every}, 99 % of them {most}"


def edge_stretch(shape: Shape, reference: Shape) -> Stretch:
    """How far a pose is from keeping the lengths of its edges.

    Parameters
    ----------
    shape, reference
        With the same faces. An edge without length on the reference does not count.

    Returns
    -------
    Stretch
        All four values are 1 for an isometry.
    """
    edges = undirected_edges(reference.faces)[0]
    before, after = (
        np.linalg.norm(each.vertices[edges[:, 0]] - each.vertices[edges[:, 1]], axis=1)
        for each in (reference, shape)
    )
    ratio = after[before > 0] / before[before > 0]
    low, high = np.quantile(ratio, [0.005, 0.995])
    return Stretch(float(ratio.min()), float(ratio.max()), float(low), float(high))

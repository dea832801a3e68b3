"""Normals, areas and winding numbers of triangle meshes, from arrays of vertices and faces.

trimesh has the same normals up to rounding (tested), but sums in another order, which would change the last
bits of bodies and scans; it has no winding number.
"""

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

THINNEST = 1e-12
"""A face has no area if twice its area is less than this share of the sum of two squared sides."""


def unit_vectors(vectors: Array) -> Array:
    """Vectors (..., 3) scaled to length 1; zero vectors stay zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1)


def scaled_face_normals(vertices: Array, faces: NDArray[np.integer]) -> Array:
    """Outward normals of the faces with a length of twice their area.

    Parameters
    ----------
    vertices : (v, 3)
    faces : (f, 3)

    Returns
    -------
    (f, 3) float64
    """
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def face_normals(vertices: Array, faces: NDArray[np.integer]) -> Array:
    """Outward unit normals of the faces; zero for a face without area.

    Parameters
    ----------
    vertices : (v, 3)
    faces : (f, 3)

    Returns
    -------
    (f, 3) float64
    """
    return unit_vectors(scaled_face_normals(vertices, faces))


def face_areas(vertices: Array, faces: NDArray[np.integer]) -> Array:
    """Areas of the faces (f,), in squared units of the vertices (v, 3)."""
    return 0.5 * np.linalg.norm(scaled_face_normals(vertices, faces), axis=1)


def first_at_places(rows: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The first of equal rows, such as vertices at one place.

    Parameters
    ----------
    rows : (v, k)

    Returns
    -------
    kept : (w,)
        First row of each kind, ascending.
    place : (v,)
        Which of `kept` each row equals.
    """
    _, first, index = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order].astype(np.int64), rank[index.ravel()].astype(np.int64)


def solid_faces(vertices: Array, faces: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Which faces (f, 3) of vertices (v, 3) have area, (f,): corners apart and not all on one line."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    one, other = b - a, c - a
    normal = np.cross(one, other)
    sides = np.einsum("fd,fd->f", one, one) + np.einsum("fd,fd->f", other, other)
    return np.einsum("fd,fd->f", normal, normal) > (THINNEST * sides) ** 2


def corner_angles(vertices: Array, faces: NDArray[np.integer]) -> Array:
    """Angles (f, 3) of the faces (f, 3) of vertices (v, 3) at their corners, radians."""
    corners, angles = vertices[faces], np.empty(faces.shape)
    for k in range(3):
        a = corners[:, (k + 1) % 3] - corners[:, k]
        b = corners[:, (k + 2) % 3] - corners[:, k]
        angles[:, k] = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("fd,fd->f", a, b))
    return angles


def vertex_normals(
    vertices: Array, faces: NDArray[np.integer], weighting: Literal["angle", "area"] = "angle"
) -> Array:
    """Outward unit normals of the vertices: weighted means of the normals of their faces.

    Parameters
    ----------
    vertices : (v, 3)
    faces : (f, 3)
    weighting
        ``"angle"``: a face counts with its angle at the vertex, whatever the triangulation [Thuermer &
        Wuethrich 1998]. ``"area"``: with its area, which is cheaper.

    Returns
    -------
    (v, 3) float64
        Zero for a vertex without faces.
    """
    total = np.zeros((len(vertices), 3))
    if weighting == "area":
        scaled = scaled_face_normals(vertices, faces)
        for k in range(3):
            np.add.at(total, faces[:, k], scaled)
        return unit_vectors(total)
    angles, normals = corner_angles(vertices, faces), face_normals(vertices, faces)
    for k in range(3):
        for d in range(3):
            total[:, d] += np.bincount(faces[:, k], angles[:, k] * normals[:, d], minlength=len(total))
    return unit_vectors(total)


def winding_number(corners: Array, place: Array) -> float:
    """How often a mesh winds about a place: 1 inside a closed mesh, 0 outside [van Oosterom & Strackee 1983].

    Parameters
    ----------
    corners : (f, 3, 3)
        Triangles.
    place : (3,)
    """
    a, b, c = (corners[:, k] - place for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    volume = np.einsum("fd,fd->f", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("fd,fd->f", u, v) for u, v in ((a, b), (b, c), (c, a)))
    return float(np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb).sum() / (2 * np.pi))


def directed_edges(faces: NDArray[np.integer]) -> NDArray[np.int64]:
    """The edges of every face in the order of its winding, (3 f, 2); rows f, f + F, f + 2F are one face."""
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)


def undirected_edges(faces: NDArray[np.integer]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Each undirected edge once, (edges, 2), and how many faces meet there: 2 on a closed manifold."""
    return np.unique(np.sort(directed_edges(faces), axis=1), axis=0, return_counts=True)

"""Points on the faces of a mesh: where a ray meets a face, and the normals that light is reflected by."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.meshes.geometry import (
    corner_angles,
    face_normals,
    solid_faces,
    unit_vectors,
    vertex_normals,
)
from datasets_gen.shape import Shape

PAIRS = 2_000_000
"""Pairs of corners that are compared at a time."""


def corner_normals(shape: Shape, shading: str, crease_angle: float = 60.0) -> NDArray[np.float64]:
    """Unit normals of the corners of the faces.

    Parameters
    ----------
    shape
    shading
        ``"flat"``: of the face. ``"smooth"``: of the vertex (`vertex_normals`); but at a vertex with a
        crease, the mean over those of its faces that are within the crease angle of the corner's own.
    crease_angle
        An edge is a crease if its faces turn by more than this, or if there are more than two; degrees.

    Returns
    -------
    (f, 3, 3) float64
        Zero for a face without area under flat shading.
    """
    normals = face_normals(shape.vertices, shape.faces)
    if shading == "flat":
        return np.repeat(normals[:, None], 3, axis=1)
    corners = vertex_normals(shape.vertices, shape.faces)[shape.faces]
    least = np.cos(np.radians(crease_angle)) - 1e-9
    solid = np.flatnonzero(solid_faces(shape.vertices, shape.faces))
    faces, normals = shape.faces[solid], normals[solid]
    creased = np.zeros(len(shape.vertices), dtype=bool)
    creased[_creases(faces, normals, least)] = True
    near = np.flatnonzero(creased[faces].any(axis=1))
    if len(near):
        face, corner = np.nonzero(creased[faces[near]])
        angles = corner_angles(shape.vertices, faces[near])[face, corner]
        vertices = faces[near[face], corner]
        corners[solid[near[face]], corner] = _means_within(vertices, normals[near[face]], angles, least)
    return corners


def _creases(faces: NDArray[np.integer], normals: NDArray[np.float64], least: float) -> NDArray[np.integer]:
    """Ends (e, 2) of the edges where the cosine between faces (f, 3) with normals (f, 3) is below `least`.

    Where more than two faces share an edge, all of it is a crease.
    """
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()  # edges 3 f, 3 f + 1, 3 f + 2 are of face f
    low, high = np.minimum(start, end).astype(np.int64), np.maximum(start, end)
    keys = low * (int(faces.max(initial=0)) + 1) + high
    order = np.argsort(keys)
    same = keys[order[1:]] == keys[order[:-1]]
    one, other = order[:-1][same], order[1:][same]
    sharp = np.einsum("ed,ed->e", normals[one // 3], normals[other // 3]) < least
    crowded = np.flatnonzero(same[1:] & same[:-1])
    found = np.concatenate([one[sharp], order[crowded]])
    return np.stack([low[found], high[found]], axis=1)


def _means_within(
    vertices: NDArray[np.integer],
    normals: NDArray[np.float64],
    weights: NDArray[np.float64],
    least: float,
) -> NDArray[np.float64]:
    """For each corner the weighted mean normal of those at its vertex whose cosine with its own is enough.

    Parameters
    ----------
    vertices : (c,)
        Vertex of each corner.
    normals : (c, 3)
        Of the faces of the corners.
    weights : (c,)
    least
        Cosine.

    Returns
    -------
    (c, 3) float64
        Unit.
    """
    order = np.argsort(vertices, kind="stable")
    _, start, count = np.unique(vertices[order], return_index=True, return_counts=True)
    first, size = np.repeat(start, count), np.repeat(count, count)  # of each corner's group, sorted
    n, w = normals[order], weights[order]
    total = np.empty_like(n)
    for part in np.split(np.arange(len(n)), _cuts(size)):
        mine = np.repeat(part, size[part])
        within = np.arange(len(mine)) - np.repeat(np.cumsum(size[part]) - size[part], size[part])
        other = first[mine] + within
        weight = w[other] * (np.einsum("pd,pd->p", n[mine], n[other]) >= least)
        for d in range(3):
            total[part, d] = np.bincount(mine - part[0], weight * n[other, d], minlength=len(part))
    out = np.empty_like(total)
    out[order] = unit_vectors(total)
    return out


def _cuts(sizes: NDArray[np.integer]) -> NDArray[np.int64]:
    """Where to cut a list so that the sizes of each part sum to about `PAIRS`."""
    return np.flatnonzero(np.diff(np.cumsum(sizes) // PAIRS)) + 1


def bent_normals(
    shading: NDArray[np.float64],
    geometric: NDArray[np.float64],
    eye: NDArray[np.float64],
    laser: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Shading normals, or those of the faces where only these face camera and laser.

    An interpolated normal may lean over the edge of a surface that is in plain view and light. A BSDF gives
    no light there, but the surface does: at the silhouettes of a coarse mesh the geometry decides.

    Parameters
    ----------
    shading, geometric : (n, 3)
        Normals: interpolated, and of the faces.
    eye, laser : (n, 3)
        Directions towards them, of any length.

    Returns
    -------
    normals : (n, 3) float64
    bent : (n,) bool
        Where they are the geometric ones.
    """

    def facing(normals: NDArray[np.float64]) -> NDArray[np.bool_]:
        return (np.einsum("nd,nd->n", normals, eye) > 0) & (np.einsum("nd,nd->n", normals, laser) > 0)

    bent = facing(geometric) & ~facing(shading)
    return np.where(bent[:, None], geometric, shading), bent


def shading_normals(
    corners: NDArray[np.float64], face_ids: NDArray[np.integer], barycentrics: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Unit normals (n, 3) at surface points, between those of the corners (f, 3, 3) of all faces."""
    return unit_vectors(np.einsum("nc,ncd->nd", barycentrics, corners[face_ids]))


def barycentrics_on(
    corners: NDArray[np.float64], rays: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Intersect rays from the origin with the planes of triangles.

    ``trimesh.triangles.points_to_barycentric`` starts from points in the planes, which are not known here.

    Parameters
    ----------
    corners : (n, 3, 3)
        Triangles in camera coordinates.
    rays : (n, 3)
        Directions.

    Returns
    -------
    barycentrics : (n, 3)
        Clipped to the triangle: single-precision tracing may choose its neighbour at an edge.
    points : (n, 3)
        The points they stand for.
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normals = (np.cross(b, c), np.cross(c, a), np.cross(a, b))
    volumes = np.stack([np.einsum("nd,nd->n", rays, normal) for normal in normals], axis=1)
    total = volumes.sum(axis=1, keepdims=True)
    weights = np.clip(volumes / np.where(total == 0, 1, total), 0, 1)
    sums = weights.sum(axis=1, keepdims=True)
    weights = np.where(sums > 0, weights / np.where(sums > 0, sums, 1), 1 / 3)
    return weights, np.einsum("nc,ncd->nd", weights, corners)

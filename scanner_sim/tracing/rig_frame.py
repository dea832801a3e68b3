"""Plain geometry of meshes: the rig's frame, normals, exact hits."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.shape import Shape


@dataclass(frozen=True)
class Frame:
    """Placement of the rig: mesh coordinates x are ``scale * (x - center)`` millimetres.

    Attributes
    ----------
    center : (3,) float64
        Centre of the mesh's bounding box, in mesh units.
    scale : float
        Millimetres per mesh unit.
    diagonal : float
        Of the bounding box, mm.
    """

    center: NDArray[np.float64]
    scale: float
    diagonal: float

    @classmethod
    def of(cls, shape: Shape, object_size: float) -> "Frame":
        """Place the rig so that the largest side of the shape measures `object_size` mm."""
        low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        scale = object_size / float((high - low).max())
        return cls((low + high) / 2, scale, scale * float(np.linalg.norm(high - low)))

    def to_rig(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mesh coordinates to mm."""
        return (points - self.center) * self.scale

    def to_mesh(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mm to mesh coordinates."""
        return points / self.scale + self.center


def vertex_normals(shape: Shape) -> NDArray[np.float64]:
    """Unit normals of the vertices, faces weighted by their angle there, (v, 3)."""
    corners = shape.vertices[shape.faces]  # (f, 3, 3)
    normals = face_normals(shape)
    out = np.zeros_like(shape.vertices)
    for k in range(3):
        a = corners[:, (k + 1) % 3] - corners[:, k]
        b = corners[:, (k + 2) % 3] - corners[:, k]
        angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("fd,fd->f", a, b))
        for d in range(3):
            out[:, d] += np.bincount(shape.faces[:, k], angle * normals[:, d], minlength=len(out))
    return _unit(out)


def face_normals(shape: Shape) -> NDArray[np.float64]:
    """Unit normals of the faces, (f, 3)."""
    a, b, c = (shape.vertices[shape.faces[:, k]] for k in range(3))
    return _unit(np.cross(b - a, c - a))


def corner_normals(shape: Shape, shading: str) -> NDArray[np.float64]:
    """Unit normals of the corners (f, 3, 3): of the vertex (``"smooth"``) or the face (``"flat"``)."""
    if shading == "flat":
        return np.repeat(face_normals(shape)[:, None], 3, axis=1)
    return vertex_normals(shape)[shape.faces]


def shading_normals(
    corners: NDArray[np.float64], face_ids: NDArray[np.integer], barycentrics: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Unit normals (n, 3) at surface points, between those of the corners (f, 3, 3) of all faces."""
    return _unit(np.einsum("nc,ncd->nd", barycentrics, corners[face_ids]))


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors scaled to length 1; zero vectors stay."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1)


def barycentrics_on(
    corners: NDArray[np.float64], rays: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Meet rays from the origin with the planes of triangles.

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


def winding_number(corners: NDArray[np.float64], place: NDArray[np.float64]) -> float:
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

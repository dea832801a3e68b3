"""Points on the faces of a mesh: where a ray meets a face, and the normals that light is reflected by."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.meshes.geometry import face_normals, unit_vectors, vertex_normals
from datasets_gen.shape import Shape


def corner_normals(shape: Shape, shading: str) -> NDArray[np.float64]:
    """Unit normals of the corners (f, 3, 3): of the vertex (``"smooth"``) or the face (``"flat"``)."""
    if shading == "flat":
        return np.repeat(face_normals(shape.vertices, shape.faces)[:, None], 3, axis=1)
    return vertex_normals(shape.vertices, shape.faces)[shape.faces]


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

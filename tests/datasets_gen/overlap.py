"""How much of a closed mesh lies inside itself, by the winding number and by exact edge-triangle tests."""

import numpy as np
from scipy.spatial import cKDTree

from datasets_gen.meshes.geometry import face_normals, winding_number


def buried_fraction(shape, samples=400, lift=2e-3, seed=0):
    """Share of surface points that are inside the body after a small step outward along the normal."""
    rng = np.random.default_rng(seed)
    faces = rng.choice(len(shape.faces), size=samples, p=shape.face_areas / shape.area)
    corners = shape.vertices[shape.faces]
    normals = face_normals(shape.vertices, shape.faces)
    points = corners[faces].mean(axis=1) + lift * normals[faces]
    winding = np.array([winding_number(corners, point) for point in points])
    return float((winding > 0.5).mean())


def crossing_faces(shape):
    """Faces that an edge of a face without common vertices passes through, as a boolean array (f,)."""
    corners = shape.vertices[shape.faces]
    centres = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    pairs = cKDTree(centres).query_pairs(2 * radii.max(), output_type="ndarray")
    gap = np.linalg.norm(centres[pairs[:, 0]] - centres[pairs[:, 1]], axis=1)
    pairs = pairs[gap <= radii[pairs].sum(axis=1)]
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


def _passes(start, end, triangles):
    """Whether segments (n, 3) pass through triangles (n, 3, 3)."""

    def volume(p, q, r, s):
        return np.einsum("nd,nd->n", np.cross(q - p, r - p), s - p)

    a, b, c = (triangles[:, k] for k in range(3))
    sides = volume(a, b, c, start) * volume(a, b, c, end) < 0
    ab, bc, ca = volume(start, end, a, b), volume(start, end, b, c), volume(start, end, c, a)
    return sides & (((ab > 0) & (bc > 0) & (ca > 0)) | ((ab < 0) & (bc < 0) & (ca < 0)))

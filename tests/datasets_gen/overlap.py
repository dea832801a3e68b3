"""How much of a closed mesh lies inside itself, by the winding number."""

import numpy as np

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

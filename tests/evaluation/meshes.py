"""Small meshes with known geometry."""

import numpy as np
import trimesh

from datasets_gen import Shape


def as_shape(vertices, faces, pose="rest", subject="test"):
    return Shape(
        np.asarray(vertices, np.float64), np.asarray(faces, np.int32), f"{subject}/{pose}", subject, pose
    )


def sphere(subdivisions=4, pose="rest"):
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    return as_shape(mesh.vertices, mesh.faces, pose)


def plane(n=12):
    """A triangulated unit square in the plane z = 0, irregular, with a boundary."""
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)])
    inner = (vertices[:, :2] > 0).all(1) & (vertices[:, :2] < 1).all(1)
    vertices[inner, :2] += np.random.default_rng(0).uniform(-0.2, 0.2, (inner.sum(), 2)) / n
    corner = np.arange(n * n).reshape(n, n)[:-1, :-1].ravel()
    faces = np.vstack(
        [
            np.column_stack([corner, corner + 1, corner + n + 1]),
            np.column_stack([corner, corner + n + 1, corner + n]),
        ]
    )
    return as_shape(vertices, faces)


def blob(subdivisions=4, bend=0.0, pose="rest"):
    """A body with two horns and no symmetry, bent by an angle per unit length: poses of one subject."""
    v = np.array(trimesh.creation.icosphere(subdivisions=subdivisions).vertices)
    faces = trimesh.creation.icosphere(subdivisions=subdivisions).faces
    v *= [1.3, 0.5, 0.35]
    v[:, 1] += 0.6 * np.exp(-12 * ((v[:, 0] - 0.7) ** 2 + v[:, 2] ** 2)) * (v[:, 1] > 0)
    v[:, 2] += 0.4 * np.exp(-12 * ((v[:, 0] + 0.3) ** 2 + v[:, 1] ** 2)) * (v[:, 2] > 0)
    if bend:
        angle = bend * v[:, 0]
        radius = 1 / bend - v[:, 1]
        v = np.column_stack([radius * np.sin(angle), 1 / bend - radius * np.cos(angle), v[:, 2]])
    return as_shape(v, faces, pose, "blob")


def random_points(shape, n, seed=0):
    rng = np.random.default_rng(seed)
    return rng.integers(len(shape.faces), size=n), rng.dirichlet([1, 1, 1], n)

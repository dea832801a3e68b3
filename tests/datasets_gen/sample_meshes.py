"""Small meshes with known properties."""

import numpy as np
import trimesh

from datasets_gen import Shape


def shape(vertices, faces, name="mesh"):
    return Shape(
        np.asarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int32), name, name, "rest"
    )


def sphere(subdivisions=3, radius=1.0):
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return shape(mesh.vertices, mesh.faces, "sphere")


def box():
    mesh = trimesh.creation.box()
    return shape(mesh.vertices, mesh.faces, "box")


def shuffled(mesh, seed=0):
    """The same mesh with vertices and faces in random order, as nothing may rely on a loader's order."""
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(mesh.vertices))
    place = np.argsort(order)
    faces = place[mesh.faces][rng.permutation(len(mesh.faces))]
    return shape(mesh.vertices[order], faces, mesh.name)

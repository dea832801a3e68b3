"""Shapes with known geometry."""

import numpy as np
import pytest
import trimesh

from datasets_gen import Shape


def to_shape(mesh, name="test/shape"):
    return Shape(
        np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int32), name, *name.split("/"), "mm"
    )


@pytest.fixture(scope="session")
def sphere():
    """Icosphere of radius 37.5 about the origin."""
    return to_shape(trimesh.creation.icosphere(subdivisions=5, radius=37.5), "test/sphere")


@pytest.fixture(scope="session")
def capsule():
    """Limb-like body along y."""
    mesh = trimesh.creation.capsule(height=45.0, radius=15.0, count=(32, 32))
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    return to_shape(mesh, "test/capsule")

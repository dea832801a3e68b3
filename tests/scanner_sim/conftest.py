"""Shapes with known geometry, and the variants of Mitsuba that work here."""

import numpy as np
import pytest
import trimesh

from datasets_gen import Shape
from scanner_sim.tracing import variant


def to_shape(mesh, name="test/shape"):
    return Shape(
        np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int32), name, *name.split("/"), "mm"
    )


@pytest.fixture(scope="session")
def sphere():
    """Icosphere of radius 37.5 about the origin."""
    return to_shape(trimesh.creation.icosphere(subdivisions=5, radius=37.5), "test/sphere")


@pytest.fixture(scope="session")
def fine_sphere():
    """The same with facets too small to matter."""
    return to_shape(trimesh.creation.icosphere(subdivisions=7, radius=37.5), "test/sphere")


@pytest.fixture(scope="session")
def capsule():
    """Limb-like body along y."""
    mesh = trimesh.creation.capsule(height=45.0, radius=15.0, count=(32, 32))
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    return to_shape(mesh, "test/capsule")


@pytest.fixture(scope="session")
def torus():
    """Ring that hides and shadows parts of itself; few faces."""
    return to_shape(trimesh.creation.torus(26, 11.5, major_sections=24, minor_sections=12), "test/torus")


@pytest.fixture(scope="session")
def cylinder():
    """Radius 20, height 75 along y."""
    mesh = trimesh.creation.cylinder(radius=20.0, height=75.0, sections=720)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    return to_shape(mesh, "test/cylinder")


@pytest.fixture(scope="session")
def plate():
    """75 x 75 x 5, its large sides facing +z and -z."""
    return to_shape(trimesh.creation.box((75.0, 75.0, 5.0)), "test/plate")


def usable(name):
    """Skip unless a variant works here."""
    outcome = variant.probe(name)[-1]
    if not outcome.works:
        pytest.skip(f"{name}: {outcome.reason}")
    return name


@pytest.fixture(params=[variant.SCALAR, variant.LLVM])
def each_variant(request, monkeypatch):
    """Run a test in the scalar and in the LLVM variant."""
    name = usable(request.param)
    monkeypatch.setattr(variant, "choose", lambda: name)
    return name

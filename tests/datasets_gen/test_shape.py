import numpy as np
import pytest

from datasets_gen import Shape
from tests.datasets_gen.sample_meshes import box, sphere


def test_repr_is_one_line():
    assert repr(box()) == "Shape('box': 8 vertices, 12 faces, units 'unknown')"


def test_areas_of_a_box():
    assert box().face_areas == pytest.approx(np.full(12, 0.5))
    assert box().area == pytest.approx(6)


def test_points_at_barycentrics():
    mesh = sphere(1)
    found = mesh.at(np.array([3, 5]), np.array([[1, 0, 0], [0.5, 0.5, 0]]))
    assert found[0] == pytest.approx(mesh.vertices[mesh.faces[3, 0]])
    assert found[1] == pytest.approx(mesh.vertices[mesh.faces[5, :2]].mean(axis=0))


def test_saved_shapes_are_read_back(tmp_path):
    mesh = sphere(1)
    mesh.save(tmp_path / "mesh.npz")
    found = Shape.load(tmp_path / "mesh.npz")
    assert np.array_equal(found.vertices, mesh.vertices)
    assert (found.name, found.subject, found.pose, found.units) == ("sphere", "sphere", "rest", "unknown")


def test_bounds_are_those_of_the_surface():
    """A unit cube about the origin; a stray vertex and one of a face without area lie far off."""
    plain = box()
    vertices = np.vstack([plain.vertices, [[9, 9, 9], [np.nan] * 3, [-7, 0, 0]]])
    given = Shape(vertices, np.vstack([plain.faces, [[0, 0, 10]]]).astype(np.int32), "box", "box", "rest")
    for mesh in (plain, given):
        assert mesh.bounds == pytest.approx(np.array([[-0.5] * 3, [0.5] * 3]))
        assert mesh.diagonal == pytest.approx(3**0.5)
    assert given.on_surface.tolist() == [True] * 8 + [False] * 3
    assert (Shape(vertices, given.faces[12:], "none", "none", "rest").bounds == 0).all()

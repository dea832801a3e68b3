"""Fields that tell the outside of a cloud."""

import numpy as np
import pytest

from datasets_gen.points import outside
from datasets_gen.points.outside import outward_field, winding_numbers
from tests.medial import clouds


def test_winding_number_of_a_sphere_is_a_half():
    points, normals = clouds.sphere(2000)
    inside = winding_numbers(points, normals)
    assert inside.min() > 0
    assert winding_numbers(points, -normals) == pytest.approx(-inside)
    ratio = inside / inside.mean()
    assert ratio.min() > 0.9
    assert ratio.max() < 1.1


def test_winding_number_does_not_depend_on_units():
    points, normals = clouds.body(600)
    assert winding_numbers(1000 * points, normals) == pytest.approx(winding_numbers(points, normals))


def test_the_field_points_out_of_a_sphere():
    points, normals = clouds.sphere(1000)
    field = outward_field(points)
    assert np.linalg.norm(field, axis=1) == pytest.approx(np.ones(1000))
    assert np.einsum("ij,ij->i", field, normals).min() > 0.9


def test_part_of_a_large_cloud_acts_for_all(monkeypatch):
    points, normals = clouds.body(2000)
    whole = winding_numbers(points, normals)
    monkeypatch.setattr(outside, "MOST_SOURCES", 500)
    part = winding_numbers(points, normals)
    assert (np.sign(part) == np.sign(whole)).mean() > 0.95


def test_points_at_one_place_feel_nothing():
    assert (outward_field(np.zeros((5, 3))) == 0).all()

"""Fields that tell the outside of a cloud."""

import numpy as np
import pytest

from datasets_gen.points import outside
from datasets_gen.points.outside import outward_field, winding_numbers
from tests.medial import clouds

AREA_PER_SQUARED_SPACING = 2 / 3**0.5
"""Points in a hexagonal packing of spacing d have d^2 sqrt(3) / 2 each, where d^2 is taken for it."""


def test_winding_number_of_a_sphere_is_a_half():
    points, normals = clouds.sphere(2000)
    inside = winding_numbers(points, normals)
    assert inside == pytest.approx(0.5 * AREA_PER_SQUARED_SPACING, rel=0.03)
    assert winding_numbers(points, -normals) == pytest.approx(-inside)


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


@pytest.mark.uncompiled
def test_points_at_one_place_feel_nothing():
    assert (outward_field(np.zeros((5, 3))) == 0).all()


@pytest.mark.uncompiled
def test_the_sums_over_few_points_are_those_of_their_definitions():
    """With squared mean distances of six neighbours as areas, softened by half their median."""
    points, normals = clouds.body(40)
    gap = points[None] - points[:, None]
    square = (gap**2).sum(axis=2)
    spacing = np.sort(np.sqrt(square), axis=1)[:, 1:7].mean(axis=1)
    weight = spacing**2 / (square + (0.5 * np.median(spacing)) ** 2) ** 1.5
    wound = (weight * np.einsum("ijd,jd->ij", gap, normals)).sum(axis=1) / (4 * np.pi)
    assert winding_numbers(points, normals) == pytest.approx(wound)
    pushed = -(weight[..., None] * gap).sum(axis=1)
    pushed /= np.linalg.norm(pushed, axis=1, keepdims=True)
    assert outward_field(points) == pytest.approx(pushed)

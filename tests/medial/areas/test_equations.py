"""Eqs. 1, 9 and 10 and the dual areas against closed forms and sums written out."""

from math import exp, sqrt

import numpy as np
import pytest

from medial.areas.equations import (
    average_distance,
    dual_area,
    incident_area,
    medial_averages,
    medial_neighbourhood,
    smoothed_density,
)

OCTAHEDRON = np.concatenate([np.eye(3), -np.eye(3)])
TRIANGLE = sqrt(3) / 2
"""Area of one of its eight triangles, of side sqrt 2."""


def triangle_area(a, b, c):
    """By Heron's formula."""
    sides = [np.linalg.norm(b - a), np.linalg.norm(c - b), np.linalg.norm(a - c)]
    half = sum(sides) / 2
    return sqrt(half * np.prod([half - side for side in sides]))


def test_density_is_a_sum_over_the_surface():
    distances, areas = [0.0, 0.3, 1.1], [0.2, 0.5, 0.4]
    expected = sum(area * exp(-d / 0.7) for d, area in zip(distances, areas, strict=True))
    assert smoothed_density(np.array(distances), np.array(areas), 0.7) == pytest.approx(expected)


def test_density_of_a_plane():
    """The integral of exp(-r / sigma) over the plane is 2 pi sigma^2."""
    r = np.linspace(0, 12, 60_001)
    rings = 2 * np.pi * r * (r[1] - r[0])
    assert smoothed_density(r, rings, 0.4) == pytest.approx(2 * np.pi * 0.4**2, rel=1e-6)


def test_every_medial_average_of_a_sphere_is_its_center():
    turn = np.random.default_rng(0)
    normals = turn.normal(size=(12, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    phi = turn.uniform(0, 0.05, (12, 12)) * (1 - np.eye(12))  # rows whose sums are below 1
    phi[4] = 0
    with np.errstate(all="raise"):
        centers, radii = medial_averages(5 + 2 * normals, normals, phi)
    assert np.isnan(radii[4])
    assert np.isnan(centers[4]).all()
    others = np.arange(12) != 4
    assert centers[others] == pytest.approx(np.full((11, 3), 5))
    assert radii[others] == pytest.approx(np.full(11, 2))


def test_medial_averages_are_weighted_by_phi():
    """A point above two parallel plates: balls of radius 1 and 2 on its normal, weighted 3 : 1."""
    points = np.array([[0.0, 0, 0], [0, 0, -2], [0, 0, -4]])
    normals = np.array([[0.0, 0, 1], [0, 0, -1], [0, 0, -1]])
    phi = np.array([[0, 0.3, 0.1], [0.3, 0, 0], [0.1, 0, 0]])
    centers, radii = medial_averages(points, normals, phi)
    assert centers[0] == pytest.approx([0, 0, -(0.3 * 1 + 0.1 * 2) / 0.4])
    assert radii == pytest.approx([(0.3 * 1 + 0.1 * 2) / 0.4, 1, 2])


def test_average_distance_is_that_of_the_nearest():
    """Gaps of 1, 1, 3 and 4 along a skew line: 1, 1, 1, 3 and 4 to the nearest."""
    along = np.array([0.0, 1, 2, 5, 9])
    assert average_distance(along[:, None] * [2 / 3, -1 / 3, 2 / 3]) == pytest.approx((1 + 1 + 1 + 3 + 4) / 5)


def test_neighbourhood_is_open():
    """Eq. 10: strictly nearer than epsilon."""
    centers = np.array([[0.0, 0, 0], [3, 4, 0], [0, 0, 6], [0, 4, 0], [30, 0, 0]])
    assert medial_neighbourhood(0, centers, 5.0).tolist() == [0, 3]
    assert medial_neighbourhood(3, centers, 5.5).tolist() == [0, 1, 3]
    assert medial_neighbourhood(4, centers, 5.0).tolist() == [4]


@pytest.mark.parametrize("own", range(6))
def test_four_triangles_meet_in_a_corner_of_an_octahedron(own):
    assert incident_area(OCTAHEDRON, own) == pytest.approx(4 * TRIANGLE)
    members = np.array([1, 2, 4, 6, 7, 8])
    points = np.full((9, 3), 50.0)
    points[members] = 3 * OCTAHEDRON + 1
    found = dual_area(members[own], members, points, np.array([0.5, 1, 2]), 7.0)
    assert found == pytest.approx(9 * 4 * TRIANGLE / 3)


def test_three_triangles_meet_in_a_corner_of_a_tetrahedron():
    """Four points are enough: three right triangles of area 1/2."""
    assert incident_area(np.concatenate([np.zeros((1, 3)), np.eye(3)]), 0) == pytest.approx(1.5)


@pytest.mark.parametrize("points", [np.eye(3), OCTAHEDRON[[0, 1, 3, 4]], np.zeros((1, 3))])
def test_flat_points_have_no_hull(points):
    assert np.isnan(incident_area(points, 0))


def test_a_point_inside_the_hull_is_projected_to_its_ball():
    """Over the middle of a face of an octahedron inscribed in the ball: a pyramid over that face."""
    center, radius = np.array([1.0, -2, 3]), 2.0
    top = np.ones(3) / sqrt(3)
    points = center + np.concatenate([radius * OCTAHEDRON * np.linspace(0.7, 1.2, 6)[:, None], [0.1 * top]])
    assert np.isnan(incident_area(points, 6))
    ball = center + radius * np.concatenate([OCTAHEDRON, [top]])
    around = [triangle_area(ball[6], ball[k], ball[(k + 1) % 3]) for k in range(3)]
    found = dual_area(6, np.arange(7), points, center, radius)
    assert found == pytest.approx(sum(around) / 3)


def test_no_dual_area_without_a_neighbourhood_or_a_hull():
    points = np.concatenate([OCTAHEDRON, [[0.3, 0.3, 0.3]]])
    assert np.isnan(dual_area(6, np.arange(6), points, np.zeros(3), 1.0))
    flat = OCTAHEDRON[[0, 1, 3, 4]] * [1, 1, 0]
    assert np.isnan(dual_area(0, np.arange(4), flat, np.array([0.1, 0.2, 0]), 1.0))

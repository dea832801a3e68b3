import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array

from medial import dual_areas, medial_axis, similarity
from medial.areas.dual_area import EPSILON, calibrated
from medial.areas.equations import (
    average_distance,
    dual_area,
    incident_area,
    medial_averages,
    medial_neighbourhood,
)
from medial.areas.hull_triangles import fan_area
from tests.medial import clouds


@pytest.fixture(scope="module")
def figure():
    points, normals = clouds.body(500, holes=4)
    phi = similarity(points, normals)
    return points, normals, phi, *medial_axis(points, normals, phi)


def written_areas(points, centers, radii, nearest=0):
    """Eq. 10 and the hulls after it; the nearest points join where asked."""
    epsilon = EPSILON * average_distance(points)
    areas = []
    for i in range(len(points)):
        near = np.linalg.norm(points - points[i], axis=1).argsort()[1 : nearest + 1]
        members = np.union1d(medial_neighbourhood(i, centers, epsilon), near)
        areas.append(dual_area(i, members, points, centers[i], radii[i]))
    return np.array(areas)


def test_medial_axis_equals_equation_9(figure):
    points, normals, phi, centers, radii = figure
    written_centers, written_radii = medial_averages(points, normals, phi.toarray())
    some = written_radii > 0
    assert some.mean() > 0.9
    assert centers[some] == pytest.approx(written_centers[some], abs=1e-9)
    assert radii[some] == pytest.approx(written_radii[some], abs=1e-9)


def test_sphere_has_one_center():
    points, normals = clouds.sphere(300, radius=2.0)
    centers, radii = medial_axis(points + 1, normals, similarity(points + 1, normals))
    assert np.abs(centers - 1).max() < 1e-9
    assert radii == pytest.approx(np.full(300, 2.0))


def test_cylinder_has_its_axis():
    points, normals = clouds.cylinder(1200)
    centers, radii = medial_axis(points, normals, similarity(points, normals))
    inner = np.abs(points[:, 2]) < 0.7
    assert np.abs(centers[inner, :2]).max() < 0.03
    assert radii[inner] == pytest.approx(np.full(inner.sum(), 0.3), rel=0.05)
    assert np.abs(centers[inner, 2] - points[inner, 2]).mean() < 0.05


def test_torus_has_its_circle():
    points, normals = clouds.torus(1500)
    centers, radii = medial_axis(points, normals, similarity(points, normals))
    assert np.median(np.abs(np.linalg.norm(centers[:, :2], axis=1) - 1)) < 0.02
    assert np.median(radii) == pytest.approx(0.3, rel=0.05)


@pytest.mark.uncompiled
def test_points_without_similar_points_take_the_nearest_radius():
    points, normals = clouds.sphere(60)
    phi = similarity(points, normals).toarray()
    phi[7], phi[:, 7] = 0, 0
    centers, radii = medial_axis(points, normals, csr_array(phi))
    assert radii[7] == pytest.approx(1)
    assert centers[7] == pytest.approx(np.zeros(3), abs=1e-9)


def test_without_any_similarity_the_center_is_the_point():
    points, normals = clouds.sphere(60)
    centers, radii = medial_axis(points, normals, csr_array((60, 60)))
    assert (centers == points).all()
    assert not radii.any()


@pytest.mark.parametrize("nearest", [0, 12])
def test_dual_areas_equal_equation_10(figure, nearest):
    points, _, _, centers, radii = figure
    written = written_areas(points, centers, radii, nearest)
    some = np.isfinite(written)
    assert some.mean() > 0.8
    found = dual_areas(points, centers, radii, nearest=nearest)
    assert found[some] == pytest.approx(written[some], rel=1e-9)


def test_concave_points_are_projected_to_their_ball():
    """Points of a torus that face its axis are inside the hull of their neighbourhood."""
    points, normals = clouds.torus(600)
    centers, radii = medial_axis(points, normals, similarity(points, normals))
    facing = np.linalg.norm(points[:, :2], axis=1) < 0.8
    written = written_areas(points, centers, radii)
    assert facing.any()
    assert np.isfinite(written[facing]).all()
    assert dual_areas(points, centers, radii)[facing] == pytest.approx(written[facing], rel=1e-9)


@pytest.mark.parametrize("radius", [0.01, 1.0, 50.0])
def test_areas_of_a_sphere_sum_to_its_area(radius):
    points, _ = clouds.sphere(800, radius)
    areas = dual_areas(points, np.zeros((800, 3)), np.full(800, radius))
    assert areas.sum() == pytest.approx(4 * np.pi * radius**2, rel=0.01)
    assert areas == pytest.approx(np.full(800, areas.mean()), rel=0.3)  # a third of 5, 6 or 7 triangles


def test_areas_fill_a_gap():
    """Half a cylinder's side is missing: points along the rim stand for it, which surface areas cannot."""
    points, normals = clouds.cylinder(1500)
    kept = points[:, 0] > -0.1
    points, normals = points[kept], normals[kept]
    centers = points - 0.3 * normals
    areas = dual_areas(points, centers, np.full(len(points), 0.3), normals)
    rim, inner = points[:, 0] < -0.07, points[:, 0] > 0.1
    assert np.median(areas[rim]) > 2 * np.median(areas[inner])


def test_a_point_without_medial_neighbours_takes_its_surface_area():
    points, normals = clouds.sphere(200)
    centers = points.copy()
    centers[1:] = 0
    centers[0] = 40.0
    areas = dual_areas(points, centers, np.ones(200), normals)
    assert areas[0] == pytest.approx(areas[1:].mean(), rel=0.2)


def test_calibrated_areas_have_the_median_of_the_surface():
    random = np.random.default_rng(0)
    surface, areas = random.uniform(1, 2, 101), random.uniform(1, 5, 101)
    assert np.median(calibrated(areas, surface) / surface) == pytest.approx(1)


def qhull_fan(offsets):
    return incident_area(np.concatenate([np.zeros((1, 3)), offsets]), 0)


@pytest.mark.uncompiled
@settings(max_examples=150, deadline=None)
@given(st.integers(0, 10**6), st.integers(3, 60), st.floats(-0.9, 1.2))
def test_fan_area_equals_qhull(seed, count, shift):
    """Corners of the hull, points on its surface's inside and deep inside, by the shift."""
    offsets = np.random.default_rng(seed).standard_normal((count, 3)) - [0, 0, shift]
    fast, slow = fan_area(offsets), qhull_fan(offsets)
    assert np.isnan(fast) == np.isnan(slow)
    if not np.isnan(slow):
        assert fast == pytest.approx(slow, rel=1e-9)


@pytest.mark.uncompiled
def test_fan_area_of_a_cube_corner_is_three_half_faces():
    corners = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    inside = 0.2 * corners + 0.1
    assert fan_area(np.concatenate([corners, inside])) == pytest.approx(1.5)


@pytest.mark.uncompiled
@pytest.mark.parametrize(
    "offsets",
    [
        np.zeros((0, 3)),
        np.eye(3)[:2],
        np.zeros((9, 3)),
        np.random.default_rng(0).standard_normal((20, 3)) * [1, 1, 0],
        np.concatenate([np.eye(3), -np.eye(3)]),
    ],
    ids=["none", "two", "coinciding", "flat", "surrounded"],
)
def test_fan_area_without_a_corner(offsets):
    assert np.isnan(fan_area(offsets))


SQUARE = np.array([[1, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]], float)
CUBE = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [0, 1, 1], [1, 0, 1], [1, 1, 1]], float)


@pytest.mark.parametrize(
    ("offsets", "area"),
    [(CUBE, 1.5), (np.concatenate([SQUARE, [[0, 0, -1]]]), np.nan)],
    ids=["a corner", "within a face"],
)
def test_last_digits_of_points_in_one_plane_do_not_matter(offsets, area):
    """The points of a column of pixels lie in one plane with the camera, up to rounding."""
    for seed in range(20):
        noise = 1e-13 * np.random.default_rng(seed).standard_normal(offsets.shape)
        assert fan_area(offsets + noise) == pytest.approx(area, nan_ok=True, rel=1e-9)


def test_threads_do_not_matter(figure, monkeypatch):
    points, _, _, centers, radii = figure
    results = []
    for threads in (1, 3):
        monkeypatch.setattr("datasets_gen.compiled.thread_count", lambda threads=threads: threads)
        results.append(dual_areas(points, centers, radii))
    assert (results[0] == results[1]).all()

"""Light from below the surface: Snell's law and the apparent depth."""

from dataclasses import replace

import numpy as np
import pytest

from scanner_sim import ScannerConfig, scan
from scanner_sim.optics import translucency

DEPTH = 100.0


def measured_depth(place, baseline):
    """Where the laser's plane through a place meets the camera's axis."""
    return place[..., 2] * baseline / (baseline - place[..., 0])


def test_refraction_obeys_snell():
    """Water at 60 degrees: sin a' = sin 60 / 1.333, a' = 40.5 degrees."""
    ray = np.array([[np.sin(np.radians(60)), 0, np.cos(np.radians(60))]])
    slope = translucency.refracted_slopes(ray, np.array([[0, 0, -1.0]]), 1.333)
    assert np.degrees(np.arctan(slope[0])) == pytest.approx([40.52, 0, 0], abs=0.01)


def test_refracted_rays_stay_in_the_plane_of_incidence():
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(50, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    rays = rng.normal(size=(50, 3))
    rays *= -np.sign((rays * normals).sum(axis=1, keepdims=True))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    slopes = translucency.refracted_slopes(rays, normals, 1.5)
    assert np.allclose((slopes * normals).sum(axis=1), 0, atol=1e-12)
    assert np.allclose((slopes * np.cross(rays, normals)).sum(axis=1), 0, atol=1e-12)
    assert ((slopes * rays).sum(axis=1) >= 0).all()
    straight = translucency.refracted_slopes(rays, normals, 1.0)
    cosine = -(rays * normals).sum(axis=1)
    oblique = cosine > translucency.LEAST_COSINE
    assert np.allclose((straight - normals)[oblique], (rays / cosine[:, None])[oblique], atol=1e-9)


def test_depths_are_exponentially_distributed():
    """Moments of the exponential distribution: k! mean^k."""
    for mean in (0.3, 2.0):
        depths, weights = translucency.scattering_depths(mean)
        assert weights.sum() == pytest.approx(1)
        assert [(weights * depths**k).sum() for k in (1, 2, 3)] == pytest.approx(
            [mean, 2 * mean**2, 6 * mean**3]
        )


@pytest.mark.parametrize("index", [1.0, 1.5])
def test_apparent_depth_of_a_plane_that_faces_the_camera(index):
    """Seen from above, the ground of a pond rises to d / n: here the laser's light comes from there."""
    point, normal = np.array([[0, 0, DEPTH]]), np.array([[0, 0, -1.0]])
    config = ScannerConfig(translucency=0.2, refractive_index=index)
    depths, _ = translucency.scattering_depths(0.2)
    for baseline in (5.0, -5.0):
        places, weights = translucency.entry_points(point, normal, baseline, config)
        found = measured_depth(places[0], baseline) - DEPTH
        assert found == pytest.approx(depths / index, rel=0.01 + depths.max() / DEPTH)
        assert weights @ found == pytest.approx(0.2 / index, rel=0.02)
    places, _ = translucency.entry_points(point, normal, 50.0, config)
    tangent = 0.5 / np.sqrt(1.25)  # sine of the laser's angle outside
    bent = tangent / index / np.sqrt(1 - (tangent / index) ** 2)
    assert places[0, :, 0] == pytest.approx(depths * bent)


def test_opaque_surfaces_are_lit_where_they_are_seen():
    point, normal = np.array([[3.0, -4.0, DEPTH]]), np.array([[0.6, 0, -0.8]])
    places, _ = translucency.entry_points(point, normal, 50.0, ScannerConfig(translucency=0.0))
    assert np.allclose(places, point[:, None])


def test_grazing_light_enters_at_a_bounded_angle():
    """Beyond the critical angle nothing is refracted: the slope inside is below 1 / sqrt(n^2 - 1)."""
    rays = np.array([[1.0, 0, 0], [1, 0, 1e-9], [np.sqrt(0.5), 0, -np.sqrt(0.5)]])
    slopes = translucency.refracted_slopes(rays, np.tile([0, 0, -1.0], (3, 1)), 1.5)
    assert np.isfinite(slopes).all()
    assert (np.linalg.norm(slopes, axis=1) <= 1 / np.sqrt(1.25)).all()


def test_a_translucent_plate_is_measured_too_deep(plate):
    """By the mean depth times tan a' / tan a: light of all depths, through stripes, sensor and detector."""
    config = ScannerConfig(
        views=((0, 0, 1),), resolution=(120, 120), bits=0, translucency=0.2, fit="centre_of_mass"
    )
    found = scan(plate, config)
    middle = np.linalg.norm(found.true_points[:, :2], axis=1) < 5
    below = (found.true_points - found.points)[middle, 2]
    depth = found.poses[0, 2, 3] - 2.5
    sine = 50 / np.hypot(50, depth)
    inside = sine / 1.5
    expected = 0.2 * inside / np.sqrt(1 - inside**2) / (50 / depth)
    assert below.mean() == pytest.approx(expected, rel=0.05)
    clear = scan(plate, replace(config, translucency=0.0))
    middle = np.linalg.norm(clear.true_points[:, :2], axis=1) < 5
    assert abs((clear.true_points - clear.points)[middle, 2].mean()) < 1e-3


def test_slopes_by_hand():
    """At 45 degrees into an index of 1.25: sin a' = 0.8 sqrt(1/2), tan a' = sqrt(0.32 / 0.68)."""
    ray = np.array([[0.5, -0.5, np.sqrt(0.5)], [0, 0, 1]])
    slopes = translucency.refracted_slopes(ray, np.tile([0, 0, -1.0], (2, 1)), 1.25)
    tangent = np.sqrt(0.32 / 0.68)
    assert slopes == pytest.approx(
        np.array([[tangent, -tangent, 0], [0, 0, 0]]) * [np.sqrt(0.5), np.sqrt(0.5), 1]
    )


def test_grazing_light_is_taken_to_be_as_oblique_as_the_least_cosine():
    rays = np.array([[1.0, 0, 0], [np.sqrt(1 - 0.01**2), 0, 0.01], [np.sqrt(1 - 0.02**2), 0, 0.02]])
    slopes = translucency.refracted_slopes(rays, np.tile([0, 0, -1.0], (3, 1)), 1.5)
    sine = np.sqrt(1 - 0.02**2) / 1.5
    assert slopes[:, 0] == pytest.approx([sine / np.sqrt(1 - sine**2)] * 3)


@pytest.mark.parametrize(("mean", "count"), [(0.01, 6), (1.0, 6), (1.4, 9), (2.0, 12), (9.0, 24)])
def test_depths_are_those_of_gauss_and_laguerre(mean, count):
    """Six per millimetre, between 6 and 24: exact up to the power 2 q - 1."""
    depths, weights = translucency.scattering_depths(mean)
    assert len(depths) == len(weights) == count
    assert weights.sum() == pytest.approx(1)
    power = min(2 * count - 1, 11)
    assert (weights * (depths / mean) ** power).sum() == pytest.approx(
        float(np.prod(np.arange(1, power + 1)))
    )


def test_entry_points_by_hand():
    """Straight through (n = 1): light seen at a depth d along the camera's ray came along the laser's."""
    point, normal = np.array([[10.0, 5, 100]]), np.array([[0, 0, -1.0]])
    places, weights = translucency.entry_points(
        point, normal, 40.0, ScannerConfig(translucency=0.5, refractive_index=1.0)
    )
    depths, expected = translucency.scattering_depths(0.5)
    sideways = np.array([10 / 100 - (10 - 40) / 100, 0, 0])
    assert places[0] == pytest.approx(point + depths[:, None] * sideways)
    assert weights == pytest.approx(expected)


def test_a_ray_along_the_normal_goes_straight_on_whatever_its_rounding():
    """A product of unit vectors may be above 1 in its last digit."""
    ray = np.array([[0, 0, 1 + 4e-16]])
    assert translucency.refracted_slopes(ray, np.array([[0, 0, -1.0]]), 1.5) == pytest.approx(
        np.zeros((1, 3))
    )

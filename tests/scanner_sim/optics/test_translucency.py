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

"""Rays through pixels, with and without a distorting lens."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scanner_sim import ScannerConfig, scan
from scanner_sim.optics.camera import camera_rays, distorted, undistorted, visible_window

LENS = {"resolution": (48, 40), "distortion": (-0.25, 0.05)}


def all_pixels(config):
    return np.stack(np.meshgrid(*map(np.arange, config.resolution), indexing="ij"), axis=-1).reshape(-1, 2)


def test_pinhole_rays_span_the_field_of_view_symmetrically():
    config = ScannerConfig(resolution=(64, 48), field_of_view=60.0)
    rays = camera_rays(all_pixels(config), config)
    assert rays[:, 0].max() == pytest.approx(np.tan(np.radians(30)) * 63 / 64)
    assert rays[:, 1].max() == pytest.approx(np.tan(np.radians(30)) * 47 / 64)
    assert np.allclose(rays.mean(axis=0), [0, 0, 1])


@given(st.floats(-0.3, 0.3), st.floats(-0.05, 0.05), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
@settings(max_examples=100, deadline=None)
def test_undistorting_inverts_distorting(k1, k2, x, y):
    assert np.allclose(undistorted(*distorted(x, y, k1, k2), k1, k2), (x, y), atol=1e-6)


def test_window_holds_every_vertex_and_no_more_than_the_image():
    config = ScannerConfig(resolution=(100, 80))
    points = np.array([[-5.0, -3, 100], [12, 20, 90], [0, 0, 80]])
    left, top, width, height = visible_window(points, config)
    image = points[:, :2] / points[:, 2:] * config.focal + [50, 40]
    assert (image >= [left, top]).all()
    assert (image <= [left + width, top + height]).all()
    assert left + width <= 100
    assert visible_window(points * [-1, 1, -1] + [0, 0, 1e3], config) is not None
    assert visible_window(points + np.array([1e4, 0, 0]), config) is None


def test_scans_through_a_distorting_lens_hit_where_the_rays_go(capsule, each_variant):
    """Projecting the true points through the lens gives back the pixels; the points stay accurate."""
    config = ScannerConfig(views=2, **LENS)
    found = scan(capsule, config)
    poses = found.poses[found.view_ids]
    local = np.einsum("nji,nj->ni", poses[:, :3, :3], found.true_points - poses[:, :3, 3])
    x, y = distorted(local[:, 0] / local[:, 2], local[:, 1] / local[:, 2], *config.distortion)
    image = np.stack([x, y], axis=1) * config.focal + np.array(config.resolution) / 2
    assert np.abs(image - found.pixels - 0.5).max() < 0.05
    assert np.abs(found.points - found.true_points).max() < 0.2
    straight = scan(capsule, ScannerConfig(views=2, resolution=LENS["resolution"]))
    assert len(found) != len(straight)

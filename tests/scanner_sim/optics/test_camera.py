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
    pinhole = local[:, :2] / local[:, 2:] * config.focal + np.array(config.resolution) / 2
    assert np.abs(pinhole - found.pixels - 0.5).max() > 0.4  # what the lens moves them by


def test_rays_by_hand():
    """Columns from the left, rows from the top; the middle of the image lies between pixels 31 and 32."""
    config = ScannerConfig(resolution=(64, 48), field_of_view=60.0)
    focal = 32 / np.tan(np.radians(30))
    rays = camera_rays(np.array([[0, 0], [40, 30], [31.5, 23.5]]), config)
    expected = [[-31.5 / focal, -23.5 / focal, 1], [8.5 / focal, 6.5 / focal, 1], [0, 0, 1]]
    assert rays == pytest.approx(np.array(expected))
    bent = ScannerConfig(resolution=(64, 48), field_of_view=60.0, distortion=(0.2, -0.1))
    x, y, _ = camera_rays(np.array([[0, 0], [40, 30]]), bent).T
    assert np.stack(distorted(x, y, 0.2, -0.1), axis=1) == pytest.approx(rays[:2, :2], abs=1e-9)
    assert not np.allclose(x, rays[:2, 0], atol=1e-4)


def test_distortion_by_hand():
    """r^2 = 0.25: a factor of 1 + 0.1 / 4 + 0.4 / 16."""
    assert distorted(0.3, -0.4, 0.1, 0.4) == pytest.approx((0.3 * 1.05, -0.4 * 1.05))
    assert undistorted(0.3 * 1.05, -0.4 * 1.05, 0.1, 0.4) == pytest.approx((0.3, -0.4), abs=1e-12)


def test_window_by_hand():
    """Vertices at columns 20.3 to 70.8 and rows 10.2 to 50.6: a pixel more on every side."""
    config = ScannerConfig(resolution=(100, 80))
    image = np.array([[20.3, 50.6], [70.8, 30.0], [40.0, 10.2]])
    depth = np.array([0.5, 90.0, 200.0])
    points = np.column_stack([(image - [50, 40]) / config.focal * depth[:, None], depth])
    assert visible_window(points, config) == (19, 9, 53, 43)  # up to columns 72 and rows 52
    beyond = image * [[-1, 1], [1, 1], [1, 3]]
    points[:, :2] = (beyond - [50, 40]) / config.focal * depth[:, None]
    assert visible_window(points, config) == (0, 29, 72, 23)
    left, above = points - [300, 0, 0] * depth[:, None] / 90, points - [0, 300, 0] * depth[:, None] / 90
    assert visible_window(left, config) is None
    assert visible_window(above, config) is None


@pytest.mark.parametrize("depth", [-5.0, 0.0, 1e-6])
def test_window_by_hand_of_what_reaches_the_eye_is_the_image(depth):
    points = np.array([[0.0, 0, 100], [1, 2, 90], [0, 0, depth]])
    assert visible_window(points, ScannerConfig(resolution=(100, 80))) == (0, 0, 100, 80)


def test_window_by_hand_behind_a_bending_lens_is_the_image():
    points = np.array([[0.0, 0, 100], [1, 2, 90]])
    assert visible_window(points, ScannerConfig(**LENS)) == (0, 0, 48, 40)

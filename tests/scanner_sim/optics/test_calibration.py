"""Errors of calibration against their derivatives, and a whole scan against both."""

import numpy as np
import pytest

from scanner_sim import ScannerConfig, scan
from scanner_sim.optics import calibration
from scanner_sim.optics.triangulation import triangulated

ERRORS = {
    "baseline_error": 0.2,
    "sheet_error": 0.05,
    "focal_error": 0.004,
    "principal_point_error": (0.7, -0.4),
}


def seen_points(config, count=2000, seed=0):
    """Points with the pixels that see them, fractions included, and the angles of their sheets."""
    rng = np.random.default_rng(seed)
    z = rng.uniform(80, 250, count)
    x, y = (rng.uniform(-0.35, 0.35, (2, count))) * z
    pixels = np.stack([x, y], axis=1) / z[:, None] * config.focal + np.array(config.resolution) / 2 - 0.5
    return np.stack([x, y, z], axis=1), pixels, np.arctan2(x - config.baseline, z)


@pytest.mark.parametrize("names", [*([name] for name in ERRORS), list(ERRORS)])
def test_depths_are_off_by_the_derivative(names):
    """Halving an error leaves a quarter of what the first order misses."""
    missed = []
    for factor in (1.0, 0.5):
        errors = {name: tuple(np.multiply(factor, ERRORS[name])) for name in names if "point" in name}
        errors |= {name: factor * ERRORS[name] for name in names if "point" not in name}
        config = ScannerConfig(**errors)
        points, pixels, angle = seen_points(config)
        found = triangulated(pixels, angle, config)[:, 2] - points[:, 2]
        expected = calibration.depth_error(points, config)
        assert np.abs(expected).max() > 0.1 * factor
        missed.append(np.abs(found - expected).max())
        assert missed[-1] < 0.06 * np.abs(expected).max()
    assert missed[1] < 0.27 * missed[0] + 1e-9


def test_a_wrong_baseline_scales_the_view_about_the_camera():
    config = ScannerConfig(baseline_error=1.0)
    points, pixels, angle = seen_points(config)
    assert np.allclose(triangulated(pixels, angle, config), points * 51 / 50)


def test_a_wrong_focal_length_and_principal_point_move_rays_as_the_pinhole_says():
    config = ScannerConfig(focal_error=0.1, principal_point_error=(3.0, -2.0), distortion=(0.05, 0.0))
    pixels = np.array([[10, 20], [199, 200], [350, 380]], np.int32)
    normalised = (calibration.assumed_pixels(pixels, config) + 0.5 - 200) / config.focal
    expected = (pixels + 0.5 - 200 - np.array([3, -2])) / (1.1 * config.focal)
    assert np.allclose(normalised, expected)


@pytest.mark.parametrize("cameras", [1, 2])
def test_a_scan_has_the_errors_of_its_calibration(plate, cameras):
    """Both cameras of a rig with one wrong encoder, baseline and lens."""
    errors = {"baseline_error": 0.3, "sheet_error": 0.1, "focal_error": 0.003}
    config = ScannerConfig(
        views=((0.1, 0.2, 1),), cameras=cameras, resolution=(120, 120), bits=0, shading="flat", **errors
    )
    found = scan(plate, config)
    for view, pose in enumerate(found.poses):
        mine = found.view_ids == view
        assert mine.sum() > 500
        local = (found.true_points[mine] - pose[:3, 3]) @ pose[:3, :3]
        gap = ((found.points - found.true_points)[mine] @ pose[:3, :3])[:, 2]
        sign = 1 - 2 * view
        seen = ScannerConfig(
            baseline=sign * 50, baseline_error=sign * 0.3, sheet_error=0.1, focal_error=0.003
        )
        expected = calibration.depth_error(local, seen)
        assert np.abs(expected).max() > 0.3
        assert np.allclose(gap, expected, atol=0.02, rtol=0.02)


def test_derivatives_by_hand():
    """At z = 100, b = 50: dz = z db / b, z^2 dtheta / (b cos^2 theta), z^2 d / (b f), z x e / b."""
    depth, angle = np.array([100.0]), np.array([np.pi / 3])
    assert calibration.baseline_depth_error(depth, 50.0, 0.2) == pytest.approx([0.4])
    assert calibration.sheet_depth_error(depth, angle, 50.0, 0.01) == pytest.approx([2 / 0.25])
    assert calibration.principal_point_depth_error(depth, 50.0, 400.0, 0.5) == pytest.approx([0.25])
    assert calibration.focal_depth_error(np.array([-20.0]), depth, 50.0, 0.01) == pytest.approx([-0.4])


def test_all_errors_add_up_by_hand():
    config = ScannerConfig(**ERRORS)
    point = np.array([[20.0, 7.0, 100.0]])
    b, square = config.baseline, 1 + ((20 - config.baseline) / 100) ** 2  # 1 / cos^2 of the sheet's angle
    expected = (
        100 * 0.2 / b
        + 100**2 * np.radians(0.05) * square / b
        + 100**2 * 0.7 / (b * config.focal)
        + 100 * 20 * 0.004 / b
    )
    assert calibration.depth_error(point, config) == pytest.approx([expected])


def test_one_error_of_the_lens_alone_by_hand():
    """The middle of the image stays with another focal length; another middle moves all pixels alike."""
    middle = np.array([[199.5, 199.5], [299.5, 99.5]])
    longer = calibration.assumed_pixels(middle, ScannerConfig(focal_error=0.25))
    assert longer == pytest.approx(np.array([[199.5, 199.5], [279.5, 119.5]]))
    for error in ((2.0, 0.0), (0.0, -3.0)):
        moved = calibration.assumed_pixels(middle, ScannerConfig(principal_point_error=error))
        assert moved == pytest.approx(middle - error)
    assert calibration.assumed_pixels(middle, ScannerConfig()) is middle


def test_errors_to_the_other_side_by_hand():
    """A shorter focal length moves pixels outward; a negative error of the sheet is one, too."""
    shorter = calibration.assumed_pixels(np.array([[299.5, 99.5]]), ScannerConfig(focal_error=-0.2))
    assert shorter == pytest.approx(np.array([[199.5 + 125, 199.5 - 125]]))
    turned = calibration.assumed_angle(np.array([0.3]), ScannerConfig(sheet_error=-2.0))
    assert turned == pytest.approx([0.3 - np.pi / 90])

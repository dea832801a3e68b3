import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from scanner_sim import ScannerConfig
from scanner_sim.optics.camera import camera_rays
from scanner_sim.optics.stripe import laser_coordinates
from scanner_sim.optics.triangulation import triangulate, triangulated


@given(st.floats(-30, 30), st.floats(-30, 30), st.floats(60, 300), st.floats(20, 80))
@settings(deadline=None)
def test_ray_and_sheet_of_a_point_meet_in_it(x, y, z, baseline):
    point = np.array([[x, y, z]])
    angle = laser_coordinates(point, baseline).angle
    assert np.allclose(triangulate(point / z, angle, baseline), point, rtol=1e-9, atol=1e-6)


def test_a_calibration_without_error_changes_no_bit():
    rng = np.random.default_rng(0)
    pixels = rng.integers(0, 400, (1000, 2)).astype(np.int32)
    angle = rng.uniform(-0.8, 0.2, 1000)
    for config in (ScannerConfig(), ScannerConfig(distortion=(0.1, 0.01))):
        plain = triangulate(camera_rays(pixels, config), angle, config.baseline)
        assert np.array_equal(triangulated(pixels, angle, config), plain)


def test_ray_and_sheet_by_hand():
    """A ray of slope 1/2 and a sheet from 30 to the right that leans left by 1/4: depth 40."""
    found = triangulate(np.array([[0.5, -0.2, 1.0]]), np.array([np.arctan(-0.25)]), 30.0)
    assert np.allclose(found, [[20, -8, 40]])
    with np.errstate(divide="ignore", invalid="ignore"):
        parallel = triangulate(np.array([[0.0, 0.1, 1.0]]), np.array([0.0]), 30.0)
    assert not np.isfinite(parallel).all()


def test_a_scanner_triangulates_with_what_it_believes():
    """With an encoder that is off by half a degree, another baseline and focal length."""
    config = ScannerConfig(resolution=(400, 400), sheet_error=0.5, baseline_error=2.0, focal_error=0.01)
    found = triangulated(np.array([[299.5, 149.5]]), np.array([-0.2]), config)
    ray = np.array([100, -50]) / (1.01 * config.focal)
    depth = (config.baseline + 2) / (ray[0] - np.tan(-0.2 + 0.5 * np.pi / 180))
    assert np.allclose(found, [[*(ray * depth), depth]])

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

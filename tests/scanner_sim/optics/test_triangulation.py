import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from scanner_sim.optics.stripe import laser_coordinates
from scanner_sim.optics.triangulation import triangulate


@given(st.floats(-30, 30), st.floats(-30, 30), st.floats(60, 300), st.floats(20, 80))
@settings(deadline=None)
def test_ray_and_sheet_of_a_point_meet_in_it(x, y, z, baseline):
    point = np.array([[x, y, z]])
    angle = laser_coordinates(point, baseline).angle
    assert np.allclose(triangulate(point / z, angle, baseline), point, rtol=1e-9, atol=1e-6)

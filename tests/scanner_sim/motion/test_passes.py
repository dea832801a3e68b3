"""When the sheet of a moving rig meets which part of the object."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from datasets_gen import InputError
from scanner_sim import ScannerConfig
from scanner_sim.motion import passes
from scanner_sim.optics import viewpoints

BOX = np.array([[x, y, z] for x in (-37.5, 37.5) for y in (-20, 20) for z in (-10, 10)])


@given(st.integers(0, 4), st.floats(0.2, 3), *[st.floats(-0.1, 0.1)] * 3)
@settings(max_examples=25, deadline=None)
def test_the_sheet_enters_the_object_with_the_first_frame_and_leaves_with_the_last(view, step, x, y, z):
    """Simulated frame by frame: rig and part move, and the corners are behind the sheet or before it."""
    config = ScannerConfig(motion="profiler", profile_step=step, part_velocity=(x, y, z))
    pose = viewpoints.poses(viewpoints.directions(5), 120.0)[view]
    path = passes.plan(BOX, pose, config)
    eye = pose[:3, 3] + path.start
    velocity = pose[:3, :3] @ [x, y, z]
    normal = np.cross(path.sheet, pose[:3, 1])
    sides = []
    for frame in range(path.frames):
        laser = eye + config.baseline * pose[:3, 0] + frame * step * pose[:3, 0]
        part = BOX + (frame - (path.frames - 1) / 2) * velocity
        sides.append((part - laser) @ normal)
    first, last = np.array(sides[0]), np.array(sides[-1])
    assert (first * np.sign(first.sum()) > -1e-9).all()
    assert (last * np.sign(last.sum()) > -1e-9).all()
    assert first.sum() * last.sum() < 0
    assert np.abs(first).min() < step + 0.2
    assert np.abs(last).min() < step + 0.2


def test_the_sheet_meets_the_axis_of_each_camera_at_the_objects_centre():
    config = ScannerConfig(motion="profiler")
    first = viewpoints.poses(viewpoints.directions(3), 130.0)
    second = viewpoints.second_camera(first, config.baseline, 130.0)
    for one, other in zip(first, second, strict=True):
        path = passes.plan(BOX, one, config)
        assert 50 + 130 * np.tan(path.angle(one)) == pytest.approx(0, abs=1e-9)
        assert -50 + 130 * np.tan(path.angle(other)) == pytest.approx(0, abs=1e-9)


def test_only_the_lit_part_of_a_mesh_is_outlined():
    """A large triangle across the sheet is cut to the width of the light."""
    config = ScannerConfig()
    local = np.array([[-60.0, -40, 130], [60, -40, 130], [0, 60, 130]])
    angle = np.arctan2(-50, 130)
    outline = passes.lit_outline(local, np.array([[0, 1, 2]]), angle, config)
    edges = 50 + 130 * np.tan(angle + config.wedge / 2 * np.array([-1, 1]))
    assert outline[:, 0].min() == pytest.approx(edges[0])
    assert outline[:, 0].max() == pytest.approx(edges[1])
    assert outline[:, 1].max() > 55
    assert len(passes.lit_outline(local + np.array([200, 0, 0]), np.array([[0, 1, 2]]), angle, config)) == 0


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"part_velocity": (0.25, 0, 0)}, "part_velocity .* never crosses"),
        ({"profile_step": 0.001}, "more than 10000; raise profile_step"),
    ],
)
def test_impossible_passes_are_refused(settings, match):
    config = ScannerConfig(motion="profiler", **settings)
    with pytest.raises(InputError, match=match):
        passes.plan_all(BOX, viewpoints.poses(viewpoints.directions(1), 120.0), config)


def test_an_object_behind_the_camera_is_refused():
    pose = np.eye(4)
    pose[2, 3] = 100
    with pytest.raises(InputError, match="view 3 has the object behind the camera"):
        passes.plan(BOX, pose, ScannerConfig(motion="profiler"), 3)

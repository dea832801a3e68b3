"""Poses of the user's own, two cameras, and rigs inside the object."""

import numpy as np
import pytest
import trimesh

from datasets_gen import InputError, Shape
from scanner_sim import ScannerConfig, scan
from tests.scanner_sim.conftest import to_shape

SMALL = {"resolution": (100, 100), "bits": 0, "fit": "least_squares"}


@pytest.fixture(scope="module")
def ridged_wall():
    """Wall with a ridge of 5 x 15 along y on the side of +z."""
    wall = trimesh.creation.box((75.0, 75.0, 5.0))
    ridge = trimesh.creation.box((5.0, 75.0, 15.0))
    ridge.apply_translation([0, 0, 10.0])
    return to_shape(trimesh.util.concatenate([wall, ridge]), "test/ridge")


def test_poses_of_a_scan_given_as_views_give_that_scan(capsule):
    """In the mesh's own frame and units."""
    moved = Shape(
        capsule.vertices * 1e-3 + [5.0, -2.0, 1.0], capsule.faces, "test/moved", "test", "moved", "m"
    )
    before = scan(moved, ScannerConfig(views=((1, 0.3, 0), (0, 0, 1)), **SMALL))
    after = scan(moved, ScannerConfig.from_dict({"views": before.poses.tolist(), **SMALL}))
    assert np.allclose(after.poses, before.poses, atol=1e-12)
    assert abs(len(after) - len(before)) <= 2
    same = np.intersect1d(*(s.view_ids * 10**6 + s.pixels @ [1000, 1] for s in (before, after)))
    assert len(same) >= len(before) - 2 > 1000
    if len(after) == len(before):
        assert np.abs(after.points - before.points).max() < 1e-6


def test_two_cameras_see_both_sides_of_a_ridge(ridged_wall):
    """The laser stands before the wall, a camera at either side: each sees one foot of the ridge only."""
    distance = 150.0
    side = np.arctan2(50, distance)
    config = ScannerConfig(
        views=((-np.sin(side), 0, np.cos(side)),), cameras=2, distance=distance, shading="flat", **SMALL
    )
    found = scan(ridged_wall, config)
    assert len(found.poses) == 2
    laser = found.poses[0, :3, 3] + 50 * found.poses[0, :3, 0] / found.scale
    assert np.allclose(laser[:2], found.true_points[:, :2].mean(axis=0), atol=0.6)
    on_wall = np.abs(found.true_points[:, 2] - 2.5) < 0.01
    feet = [(found.true_points[:, 0] > a) & (found.true_points[:, 0] < b) for a, b in ((-6, -3), (3, 6))]
    counts = np.array([[(on_wall & foot & (found.view_ids == v)).sum() for foot in feet] for v in (0, 1)])
    assert (counts[[0, 1], [1, 0]] == 0).all()
    assert (counts[[0, 1], [0, 1]] > 100).all()
    assert abs(int(counts[0, 0]) - int(counts[1, 1])) < 0.1 * counts[0, 0]
    assert np.abs(found.points - found.true_points).max() < 1e-6


def test_one_placement_error_moves_both_cameras_of_a_rig(sphere):
    config = ScannerConfig(views=2, cameras=2, registration_error=2.0, **SMALL)
    found = scan(sphere, config)
    gap = found.points - found.true_points
    for station in (0, 1):
        mine = found.view_ids % 2 == station
        assert len(np.unique(found.view_ids[mine])) == 2
        truth = np.c_[found.true_points[mine], np.ones(mine.sum())]
        motion, *_ = np.linalg.lstsq(truth, gap[mine], rcond=None)
        assert np.abs(truth @ motion - gap[mine]).max() < 1e-2  # one rigid motion explains both
        assert np.abs(gap[mine]).max() > 0.1


def test_poses_inside_the_object_are_refused(sphere):
    outside, inside = np.eye(4), np.eye(4)
    outside[2, 3], inside[2, 3] = -150, -20
    with pytest.raises(InputError, match="camera of view 1 stands inside"):
        scan(sphere, ScannerConfig(views=(outside.tolist(), inside.tolist()), **SMALL))
    inside[:2, 3] = -50, 0
    with pytest.raises(InputError, match="laser of view 0 stands inside"):
        scan(sphere, ScannerConfig(views=(inside.tolist(),), **SMALL))

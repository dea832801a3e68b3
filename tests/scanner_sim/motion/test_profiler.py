"""The line profiler against spheres and planes, at rest and moving."""

import numpy as np
import pytest

from datasets_gen import InputError
from scanner_sim import ScannerConfig, scan
from scanner_sim.motion import passes
from scanner_sim.scanner import Rig

FRONT = {"views": ((0, 0, 1),), "motion": "profiler", "resolution": (200, 200)}
PRECISE = {**FRONT, "fit": "least_squares", "bits": 0, "stripe_width": 1.2, "profile_step": 3.0}
DISTANCE = 70 + 37.5 * np.sqrt(3)
ACROSS = np.array([1, 0, 50 / DISTANCE])  # the sheet holds x - b - z tan(theta), tan(theta) = -b / D


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def in_camera(points):
    """From the rig, which the camera watches along -z with y up."""
    return points * [1, -1, -1] + [0, 0, DISTANCE]


def sheared(velocity, step):
    """Map of the sphere's points about its centre: each moves on until the sheet is there.

    After k frames the sheet, which moves by step k, meets a point p at p + k v.
    """
    velocity = np.asarray(velocity)
    return np.eye(3) + np.outer(velocity, ACROSS) / (step - velocity @ ACROSS)


@pytest.mark.parametrize("velocity", [(0, 0, 0), (0.3, 0, 0), (0, 0.4, 0), (0.2, -0.3, 0.25)])
def test_a_moving_sphere_becomes_the_sheared_sphere(sphere, velocity):
    found = scan(sphere, ScannerConfig(**PRECISE, part_velocity=velocity))
    bright = found.intensity > 0.4
    seen = (in_camera(found.points) - [0, 0, DISTANCE])[bright]
    assert len(seen) > 1500
    gap = np.linalg.norm(seen @ np.linalg.inv(sheared(velocity, 3.0)).T, axis=1) - 37.5
    assert rms(gap) < 0.02
    if any(velocity):
        assert rms(np.linalg.norm(seen, axis=1) - 37.5) > 0.5


def test_a_part_that_moves_with_the_rig_is_stretched(sphere):
    """The sheet then passes over it more slowly: volumes grow by the step over what is left of it."""
    assert np.linalg.det(sheared((1.0, 0.1, 0), 3.0)) == pytest.approx(3.0 / 2.0)
    still, moving = (
        Rig(sphere, ScannerConfig(**PRECISE, part_velocity=(v, 0.1, 0))).passes[0].frames for v in (0.0, 1.0)
    )
    assert moving / still == pytest.approx(3 / 2, abs=0.05)


def test_truth_lies_on_the_surface_where_the_camera_of_the_frame_looks(sphere, each_variant):
    """Poses are those of the first frame; the camera then moves by the step along its x."""
    config = ScannerConfig(**{**PRECISE, "profile_step": 4.0})
    found = scan(sphere, config)
    assert len(found.poses) == 1
    frame, row = found.pixels.T
    local = (found.true_points - found.poses[0, :3, 3]) @ found.poses[0, :3, :3]
    local[:, 0] -= 4.0 * frame
    image = local[:, :2] / local[:, 2:] * config.focal + np.array(config.resolution) / 2 - 0.5
    assert rms(image[:, 0] - found.angle) < 0.05
    assert rms(image[:, 1] - row) < 0.05
    assert np.allclose(sphere.at(found.face_ids, found.barycentrics), found.true_points)
    assert np.einsum("nd,nd->n", found.normals, found.true_points).min() > 0.99 * 37.5


def test_the_line_is_as_wide_as_the_sheet(plate):
    """On a plane that faces the camera the wedge has s = F / sqrt(32), stretched by 1 / cos^2(theta)."""
    config = ScannerConfig(**{**FRONT, "bits": 0, "fit": "least_squares", "shading": "flat"}, profile_step=9)
    found = scan(plate, config)
    middle = np.abs(found.pixels[:, 1] - 99.5) < 10
    theta = np.arctan2(-50, 70 + np.linalg.norm([75, 75, 5]) / 2)
    expected = config.wedge / np.sqrt(32) * config.focal / np.cos(theta) ** 2
    assert np.median(found.width[middle]) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("cameras", [1, 2])
@pytest.mark.parametrize("footprint", [1, 3])
def test_a_plane_is_measured_flat_and_complete(plate, cameras, footprint):
    config = ScannerConfig(
        **{**PRECISE, "profile_step": 12.0, "resolution": (100, 100), "stripe_width": 2.4},
        shading="flat",
        cameras=cameras,
        footprint=footprint,
    )
    found = scan(plate, config)
    front = np.abs(found.true_points[:, 2] - 2.5) < 1e-6
    inner = front & (np.abs(found.true_points[:, :2]) < 33).all(axis=1)
    assert rms(found.points[inner, 2] - 2.5) < 0.03
    frames = found.pixels[inner, 0]
    for view in range(cameras):
        mine = found.view_ids[inner] == view
        rows = np.unique(frames[mine], return_counts=True)[1]
        assert len(rows) == 6
        assert np.ptp(rows) <= 2  # whole profiles
        assert rows.min() > 55


def test_noise_is_that_of_the_seed_and_of_the_frame(sphere):
    settings = {**FRONT, "profile_step": 15.0, "resolution": (120, 120), "peak_threshold": 0.5}
    a, b, c = (scan(sphere, ScannerConfig(**settings, noise=0.3), seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(a.points, b.points)
    quiet = scan(sphere, ScannerConfig(**settings))
    _, i, j = np.intersect1d(*(each.pixels @ [1000, 1] for each in (a, c)), return_indices=True)
    errors = [(each.points - each.true_points)[k, 2] for each, k in ((a, i), (c, j))]
    assert len(i) > 100
    assert abs(np.corrcoef(errors)[0, 1]) < 0.5  # what they share is the bias of the stripe's phase
    assert rms((a.points - a.true_points)[:, 2]) > 1.5 * rms((quiet.points - quiet.true_points)[:, 2])


def test_the_rig_never_passes_through_the_object(sphere):
    """The middle of the pass is what stands inside here."""
    with pytest.raises(InputError, match="camera of view 0 stands inside"):
        Rig(sphere, ScannerConfig(**FRONT, distance=15.0))


def test_a_camera_that_never_sees_the_line_is_told(plate):
    """Images so low that no row holds the object, which the rig passes by."""
    pose = np.eye(4)
    pose[:3, 3] = 0, -160, -130
    with pytest.raises(InputError, match="camera sees the laser's line on"):
        scan(plate, ScannerConfig(**{**FRONT, "views": (pose.tolist(),), "profile_step": 10.0}))


@pytest.mark.parametrize("kind", ["pca", "mst"])
def test_signs_of_normals_are_seen_from_the_frame_and_not_from_the_first(sphere, kind):
    """The first frame would look at the far side of the sphere from behind."""
    settings = {**FRONT, "resolution": (100, 100), "fit": "least_squares", "peak_threshold": 0.3}
    found = scan(sphere, ScannerConfig(**{**settings, "profile_step": 2.0}, normals=kind))
    first = np.einsum("nd,nd->n", found.normals, found.poses[0, :3, 3] - found.points)
    assert (first < 0).mean() > 0.02
    assert np.einsum("nd,nd->n", found.normals, found.true_points).min() > 0


def test_passes_of_both_cameras_are_one_motion(sphere):
    rig = Rig(sphere, ScannerConfig(**FRONT, cameras=2))
    assert len(rig.poses) == 2
    assert len(rig.passes) == 1
    gap = rig.poses[1, :3, 3] - rig.poses[0, :3, 3]
    assert np.linalg.norm(gap) == pytest.approx(2 * 50 * np.cos(np.arctan2(50, DISTANCE)), rel=1e-3)
    assert passes.MOST_FRAMES > rig.passes[0].frames > 300

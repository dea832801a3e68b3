"""From where a cloud was seen, and what it would therefore show, against geometry that is known."""

import numpy as np
import pytest

from datasets_gen.points.fibonacci import fibonacci_sphere
from medial.matching.registration.visibility import (
    FINEST,
    DepthMap,
    Visibility,
    from_one_side,
    typical_spacing,
)


def sphere(n=3000, centre=(0.0, 0.0, 0.0), radius=1.0):
    normals = fibonacci_sphere(n)
    return radius * normals + np.array(centre), normals


def seen_from(toward, points, normals, least=0.3):
    kept = normals @ (np.asarray(toward) / np.linalg.norm(toward)) > least
    return points[kept], normals[kept]


def test_a_sphere_seen_from_one_side_shows_that_side_alone():
    points, normals = sphere()
    shown = Visibility.of(*seen_from((0, 0, 1), points, normals))
    assert all(each.toward[2] > 0.5 for each in shown.maps)
    expected = shown.expected(points, normals)
    assert expected[normals[:, 2] > 0.7].mean() > 0.85
    assert expected[normals[:, 2] > 0.9].min() > 0.5
    assert expected[normals[:, 2] < -0.1].max() == 0


def test_a_sphere_seen_from_all_sides_shows_everything():
    points, normals = sphere()
    shown = Visibility.of(points, normals)
    assert shown.expected(points, normals).mean() > 0.8  # the rest is steep to every direction


def test_what_lies_behind_the_cloud_is_hidden():
    points, normals = sphere()
    near, near_normals = seen_from((0, 0, 1), points, normals)
    each = DepthMap.of(near, np.array([0.0, 0.0, 1.0]), 0.06)
    assert each.free(near[near_normals[:, 2] > 0.85]).all()
    assert not each.free(np.array([[0.0, 0.0, -3.0]]))[0]
    assert each.free(np.array([[2.0, 0.0, -3.0]]))[0]


@pytest.mark.parametrize("slack", [1.0, "each"])
def test_free_points_against_numpy(slack):
    random = np.random.default_rng(0)
    points, _ = sphere(500)
    each = DepthMap.of(points, np.array([0.6, 0.0, 0.8]), 0.1)
    tried = 1.5 * random.standard_normal((400, 3))
    slack = random.uniform(1, 4, len(tried)) if slack == "each" else slack
    free = []
    for point in tried:
        row, column = np.floor((point @ each.axes - each.corner) / each.cell).astype(int)
        on_map = 0 <= row < each.depth.shape[0] and 0 <= column < each.depth.shape[1]
        free.append(np.inf if not on_map else each.depth[row, column])
    expected = -(tried @ each.toward) <= np.array(free) + slack * each.margin
    assert np.array_equal(each.free(tried, slack), expected)
    assert 0.2 < expected.mean() < 0.9


@pytest.mark.parametrize("toward", [(0, 0, 1), (1, 2, -0.5)])
def test_a_cap_was_seen_from_one_side_a_sphere_and_a_band_were_not(toward):
    points, normals = sphere()
    assert from_one_side(*seen_from(toward, points, normals, 0.1))
    assert not from_one_side(points, normals)
    height = normals @ (np.asarray(toward) / np.linalg.norm(toward))
    band = np.abs(height) < 0.5
    assert not from_one_side(points[band], normals[band])


def test_what_one_shell_hides_was_not_seen_from_its_side():
    outer = seen_from((0, 0, 1), *sphere(), least=0.1)
    beside = seen_from((0, 0, 1), *sphere(1000, (2.0, 0.0, 0.0), 0.5), least=0.1)
    inside = seen_from((0, 0, 1), *sphere(1000, radius=0.5), least=0.1)
    assert from_one_side(*map(np.concatenate, zip(outer, beside, strict=True)))
    assert not from_one_side(*map(np.concatenate, zip(outer, inside, strict=True)))


def test_points_at_one_place_have_no_side():
    assert not from_one_side(np.zeros((30, 3)), np.tile([0.0, 0.0, 1.0], (30, 1)))


@pytest.mark.parametrize("angle", [20.0, 40.0])
def test_directions_are_found_where_the_scanner_stood(angle):
    """Two cameras: the directions of the cloud lie within the cone that they span."""
    points, normals = sphere()
    tilt = np.radians(angle)
    eyes = np.array([[np.sin(tilt), 0, np.cos(tilt)], [-np.sin(tilt), 0, np.cos(tilt)]])
    kept = (normals @ eyes.T).max(axis=1) > 0.7
    shown = Visibility.of(points[kept], normals[kept])
    for each in shown.maps:
        assert (eyes @ each.toward).max() > np.cos(np.radians(40))
    assert 0.5 < shown.least < 0.95


def test_visibility_turns_and_scales_with_the_cloud():
    from scipy.spatial.transform import Rotation

    points, normals = seen_from((0, 0, 1), *sphere())
    turn = Rotation.from_rotvec([0.3, -1.0, 0.5])
    probes = fibonacci_sphere(300)
    before = Visibility.of(points, normals).expected(probes, probes)
    after = Visibility.of(3 * turn.apply(points), turn.apply(normals)).expected(
        3 * turn.apply(probes), turn.apply(probes)
    )
    assert np.abs(before - after).mean() < 0.15


def test_repeated_points_do_not_count_for_the_spacing():
    random = np.random.default_rng(0)
    points = random.normal(size=(200, 3))
    once = typical_spacing(points)
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    np.fill_diagonal(apart, np.inf)
    nearest = apart.min(axis=1)
    assert once == pytest.approx(np.median(nearest))
    most = np.concatenate([points, points[:150]])
    assert typical_spacing(most) == pytest.approx(np.median(nearest[150:]))
    assert typical_spacing(np.repeat(points, 3, axis=0)) == pytest.approx(once)
    assert typical_spacing(np.ones((5, 3))) == 0


def test_cells_are_no_smaller_than_a_share_of_the_extent():
    """Pairs of points that nearly coincide: a map with cells of their distance would fill the memory."""
    points = np.repeat(np.random.default_rng(0).normal(size=(100, 3)), 2, axis=0)
    points[::2] += 1e-9
    assert typical_spacing(points) == pytest.approx(np.ptp(points, axis=0).max() / FINEST)

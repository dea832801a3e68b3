"""The light of the sheet against the formula and against every stripe evaluated at every point."""

import numpy as np
import pytest

from scanner_sim import ScannerConfig
from scanner_sim.optics import peak, stripe


def points_before_camera(n=200, seed=0):
    rng = np.random.default_rng(seed)
    z = rng.uniform(80, 180, n)
    return np.stack([rng.uniform(-0.35, 0.35, n) * z, rng.uniform(-0.35, 0.35, n) * z, z], axis=1)


def test_wedge_is_the_gaussian_of_the_distance_to_the_sheet():
    """Written out from points and planes, without angles."""
    config = ScannerConfig()
    points = points_before_camera()
    eye = np.array([config.baseline, 0, 0])
    r = np.linalg.norm(points - eye, axis=1)
    laser = stripe.laser_coordinates(points, config.baseline)
    for theta in (-0.35, -0.2, 0.0):
        normal = np.array([np.cos(theta), 0, -np.sin(theta)])
        gap = np.abs((points - eye) @ normal)
        sigma = r * np.tan(config.wedge / 2) / 2
        expected = np.exp(-2 * (gap / sigma) ** 2)
        expected[np.abs(theta - laser.angle) > config.wedge / 2] = 0
        got = stripe.wedge(theta - laser.angle, laser.axis_distance / laser.distance, config.wedge)
        assert np.allclose(got, expected)


def test_width_of_the_stripe_is_that_of_the_reference_program():
    """Fits of the reference program's output that iterated have s / F = .1763; its formula gives .1768."""
    config = ScannerConfig()
    laser = stripe.laser_coordinates(np.array([[0.0, 0.0, 120.0]]), config.baseline)
    assert stripe.cast_width(laser, config)[0] / config.wedge == pytest.approx(0.1768, abs=1e-4)
    swept = stripe.swept_stripes(laser, config)
    found = peak.fit(swept.values, "least_squares")
    assert found.width[0] * config.step / config.wedge == pytest.approx(0.1763, rel=5e-3)
    assert 7 <= (swept.values > 0).sum() <= 8  # "about 7 stripes per pixel"


@pytest.mark.parametrize("beam", ["wedge", "gaussian"])
def test_sweep_holds_every_stripe_that_lights_a_point(beam):
    config = ScannerConfig(beam=beam)
    laser = stripe.laser_coordinates(points_before_camera(), config.baseline)
    swept = stripe.swept_stripes(laser, config)
    number = np.arange(config.stripes)
    theta = config.sweep[0] + (number + 0.5) * config.step
    dense = stripe.light(theta - laser.angle[:, None], laser, config)
    column = swept.first[:, None] + np.arange(swept.values.shape[1])
    found = np.zeros_like(dense)
    inside = (column >= 0) & (column < config.stripes)
    found[np.nonzero(inside)[0], column[inside]] = swept.values[inside]
    assert np.allclose(found, dense)
    assert (swept.values[~inside] == 0).all()


@pytest.mark.parametrize("beam", ["wedge", "gaussian"])
def test_fit_of_a_clean_sweep_finds_angle_width_and_height(beam):
    config = ScannerConfig(beam=beam)
    laser = stripe.laser_coordinates(points_before_camera(), config.baseline)
    swept = stripe.swept_stripes(laser, config)
    inner = (swept.first > 0) & (swept.first + swept.values.shape[1] < config.stripes)
    assert inner.mean() > 0.8
    found = peak.fit(swept.values, "least_squares")
    angle = config.sweep[0] + (swept.first + found.position + 0.5) * config.step
    assert np.abs(angle - laser.angle)[inner].max() < 1e-6
    width = stripe.cast_width(laser, config)
    assert np.abs(found.width * config.step / width - 1)[inner].max() < 2e-3
    height = 1 if beam == "wedge" else config.beam_waist / stripe.beam_radius(laser.distance, config)
    assert np.abs(found.peak / height - 1)[inner].max() < 2e-3


def test_gaussian_beam_diverges_from_its_waist_and_keeps_its_power():
    config = ScannerConfig(beam="gaussian", beam_waist=0.1)
    focus = config.focus
    assert stripe.beam_radius(np.array([focus]), config) == pytest.approx(0.1)
    rayleigh = np.pi * 0.1**2 / 650e-6
    assert stripe.beam_radius(np.array([focus + rayleigh]), config) == pytest.approx(0.1 * np.sqrt(2))
    offset = np.linspace(-0.05, 0.05, 20001)
    power = [
        np.trapezoid(stripe.gaussian(offset, axis, radius, 0.1), axis * np.sin(offset))
        for axis, radius in ((100.0, 0.1), (150.0, 0.2))
    ]
    assert power[0] == pytest.approx(power[1], rel=1e-3)


def test_inverse_square_falloff():
    config = ScannerConfig(falloff="inverse_square")
    laser = stripe.laser_coordinates(
        np.array([[0, 0, config.min_range], [config.baseline, 0, 2 * config.nearest]]), 50.0
    )
    assert np.allclose(stripe.falloff(laser, config), [1, 0.25])


def test_stripes_cover_the_field_of_view_over_the_whole_range():
    """Ranges are distances from the eye along the rays at the image's edges."""
    config = ScannerConfig()
    first, last = config.sweep
    for reach in (config.min_range, 150.0, config.max_range):
        depth = reach / np.hypot(1, config.half_width)
        edge = config.half_width * depth
        corners = stripe.laser_coordinates(
            np.array([[-edge, 0, depth], [edge, 0, depth]]), config.baseline
        ).angle
        assert first - 1e-12 <= corners.min()
        assert corners.max() <= last + 1e-12


def test_laser_coordinates_by_hand():
    """A point 3 to the right of the laser, 12 below it and 4 ahead: 5 from the axis, 13 from the laser."""
    found = stripe.laser_coordinates(np.array([[53.0, 12.0, 4.0]]), 50.0)
    assert found.axis_distance == pytest.approx([5])
    assert found.distance == pytest.approx([13])
    assert np.tan(found.angle) == pytest.approx([3 / 4])


def test_wedge_by_hand_and_its_edges():
    """At half the full angle from the middle, rho = r: exp(-8 (sin / tan)^2), and nothing beyond."""
    angle = 0.6
    found = stripe.wedge(np.array([0.0, 0.3, -0.3, 0.3001, 0.1]), np.array([1, 1, 1, 1, 0.5]), angle)
    edge = np.exp(-8 * np.cos(0.3) ** 2)
    assert found == pytest.approx([1, edge, edge, 0, np.exp(-2 * (np.sin(0.1) / np.tan(0.3)) ** 2)])


def test_gaussian_beam_by_hand_and_its_cut():
    """1/e^2 of the peak at the radius; cut where 1e-4 of it is left."""
    offset = np.arcsin(np.array([0, 0.5, 1, 2.149, 2.151, -2.151]) * 0.2 / 100)
    found = stripe.gaussian(offset, 100.0, 0.2, 0.1)
    assert found[:3] == pytest.approx(0.5 * np.exp([0, -0.5, -2]))
    assert found[3] / found[0] == pytest.approx(1e-4, rel=0.05)
    assert found[4:].tolist() == [0, 0]


def test_beam_radius_by_hand():
    """A waist of 0.1 mm at 500 nm: a Rayleigh range of pi 0.01 / 5e-4 = 62.8 mm."""
    config = ScannerConfig(beam="gaussian", beam_waist=0.1, wavelength=500.0)
    away = 0.75 * 20 * np.pi
    found = stripe.beam_radius(config.focus + np.array([-away, 0, away]), config)
    assert found == pytest.approx([0.125, 0.1, 0.125])


def coordinates(axis, distance, angle=0.0):
    axis, distance = np.array(axis, float), np.array(distance, float)
    return stripe.LaserCoordinates(np.full(len(axis), angle), axis, distance)


def test_half_angles_are_where_the_light_ends():
    wedge = ScannerConfig(beam="wedge")
    assert stripe.half_angle(coordinates([90, 70], [100, 100]), wedge).tolist() == [wedge.wedge / 2] * 2
    beam = ScannerConfig(beam="gaussian", beam_waist=0.1)
    radius = stripe.beam_radius(np.array([100.0]), beam)[0]
    found = stripe.half_angle(coordinates([80, 1e-3], [100, 100]), beam)
    assert np.sin(found[0]) * 80 == pytest.approx(2.15 * radius)
    assert found[1] == pytest.approx(np.pi / 2)  # all around, so near the axis


@pytest.mark.parametrize("beam", ["wedge", "gaussian"])
def test_cast_width_is_where_one_over_e_of_the_light_is_left(beam):
    config = ScannerConfig(beam=beam)
    laser = coordinates([80, 100], [100, 130])
    width = stripe.cast_width(laser, config)
    lit = stripe.light(np.stack([0 * width, width], axis=1), laser, config)
    assert lit[:, 1] / lit[:, 0] == pytest.approx(np.exp([-1, -1]), rel=1e-3)


def test_falloff_is_one_over_the_square_of_the_distance_or_none():
    laser = coordinates([80, 80], [100, 300])
    assert stripe.falloff(laser, ScannerConfig(falloff="none")).tolist() == [1, 1]
    near, far = stripe.falloff(laser, ScannerConfig(falloff="inverse_square"))
    assert near / far == pytest.approx(9)


@pytest.mark.parametrize("beam", ["wedge", "gaussian"])
@pytest.mark.parametrize("margin", [0.0, 0.013])
def test_rows_hold_the_stripes_that_light_a_point_and_the_margin(beam, margin):
    """Number by number, also beyond the sweep; rows are as long as the widest stripe, and two at most."""
    config = ScannerConfig(beam=beam, stripes=200)
    laser = stripe.laser_coordinates(points_before_camera(60), config.baseline)
    found = stripe.swept_stripes(laser, config, margin)
    half = stripe.half_angle(laser, config) + margin
    numbers = np.arange(-200, 600)
    theta = config.sweep[0] + (numbers + 0.5) * config.step
    near = np.abs(theta - laser.angle[:, None]) <= half[:, None]
    assert found.first.tolist() == numbers[near.argmax(axis=1)].tolist()
    assert near.sum(axis=1).max() <= found.values.shape[1] < 2 * half.max() / config.step + 2
    for k, first in enumerate(found.first):
        row = (
            config.sweep[0] + (first + np.arange(found.values.shape[1]) + 0.5) * config.step - laser.angle[k]
        )
        alone = stripe.LaserCoordinates(laser.angle[[k]], laser.axis_distance[[k]], laser.distance[[k]])
        lit = stripe.light(row[None], alone, config)[0]
        number = first + np.arange(len(row))
        assert found.values[k] == pytest.approx(np.where((number >= 0) & (number < 200), lit, 0))


def test_no_points_have_no_stripes():
    none = stripe.laser_coordinates(np.empty((0, 3)), 50.0)
    assert stripe.swept_stripes(none, ScannerConfig()).values.shape == (0, 1)


def test_offsets_by_hand():
    config = ScannerConfig(stripes=200)
    start, step = config.sweep[0], config.step
    offset, inside = stripe.offsets(np.array([-1, 198]), 3, np.array([0.1, -0.2]), config)
    assert offset == pytest.approx(
        np.array(
            [
                [start + (k + 0.5) * step - 0.1 for k in (-1, 0, 1)],
                [start + (k + 0.5) * step + 0.2 for k in (198, 199, 200)],
            ]
        )
    )
    assert inside.tolist() == [[False, True, True], [True, True, False]]

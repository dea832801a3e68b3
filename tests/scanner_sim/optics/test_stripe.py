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

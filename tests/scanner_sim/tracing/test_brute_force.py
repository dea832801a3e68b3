"""The synthesis against Mitsuba rendering every stripe with a projector."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.ndimage import gaussian_filter

from scanner_sim import ScannerConfig, scan
from scanner_sim.optics import stripe
from scanner_sim.optics.measurement import samples
from scanner_sim.scanner import Rig
from scanner_sim.tracing import brute_force
from tests.scanner_sim.conftest import to_shape


def synthesised(hits, config, numbers):
    """Noise-free intensities of the lit hits under given stripes, and the angles to the wedge's edge."""
    index = np.flatnonzero(hits.radiance > 0)
    laser = stripe.laser_coordinates(hits.points[index], config.baseline)
    rows = samples(hits, config, 0, 0).rows
    first, values = rows.first, rows.padded(np.arange(len(index)))
    column = numbers - first[:, None]
    inside = (column >= 0) & (column < values.shape[1])
    picked = np.take_along_axis(values, np.clip(column, 0, values.shape[1] - 1), axis=1)
    theta = config.sweep[0] + (numbers + 0.5) * config.step
    return (
        index,
        laser,
        np.where(inside, picked, 0),
        np.abs(np.abs(theta - laser.angle[:, None]) - config.wedge / 2),
    )


@pytest.mark.parametrize("material", ["white", "plastic"])
def test_synthesis_equals_rendering_every_stripe(torus, each_variant, material):
    """Per-pixel relative L2 below 1e-3, over all stripes that light a band of the object."""
    config = ScannerConfig(
        views=3, resolution=(64, 64), stripes=130, bits=0, material=material, shading="flat"
    )
    rig = Rig(torus, config)
    hits = rig.tracer.view(rig.poses[1])
    numbers = np.arange(50, 80)
    index, laser, synthetic, to_edge = synthesised(hits, config, numbers)
    rendered = brute_force.render(rig.tracer, rig.poses[1], hits.pixels[index], numbers)
    rendered = np.minimum(rendered * laser.distance[:, None] ** 2, 1)
    sure = to_edge > 1e-5  # at the wedge's very edge single precision decides
    rendered, synthetic = rendered * sure, synthetic * sure
    lit = np.linalg.norm(synthetic, axis=1) > 0.05
    assert lit.sum() > 300
    error = np.linalg.norm(rendered - synthetic, axis=1)[lit] / np.linalg.norm(synthetic, axis=1)[lit]
    assert error.max() < 1e-3


def test_smoothing_equals_blurring_the_rendered_images(plate):
    config = ScannerConfig(
        views=((0.3, 0.2, 1.0),), resolution=(60, 60), stripes=150, bits=0, smoothing=1.2, shading="flat"
    )
    rig = Rig(plate, config)
    hits = rig.tracer.view(rig.poses[0])
    numbers = np.arange(70, 74)
    index, laser, synthetic, _ = synthesised(hits, config, numbers)
    sharp = (
        brute_force.render(rig.tracer, rig.poses[0], hits.pixels[index], numbers)
        * laser.distance[:, None] ** 2
    )
    column, row = hits.pixels[index].T
    for k in range(len(numbers)):
        image = np.zeros((60, 60))
        image[row, column] = sharp[:, k]
        blurred = gaussian_filter(image, 1.2, mode="constant", radius=4)[row, column]
        assert np.linalg.norm(blurred - synthetic[:, k]) < 5e-3 * np.linalg.norm(blurred)


def test_interreflection_adds_light_in_a_corner():
    """Two white plates at a right angle light each other, the more the nearer to the corner."""
    floor = trimesh.creation.box((40, 2, 40))
    wall = trimesh.creation.box((40, 40, 2), trimesh.transformations.translation_matrix([0, 20, -20]))
    shape = to_shape(trimesh.util.concatenate([floor, wall]), "test/corner")
    config = ScannerConfig(
        views=((0, 1, 1),),
        resolution=(24, 24),
        stripes=60,
        stripe_width=6.0,
        shading="flat",
        falloff="inverse_square",
        residual_threshold=1.0,
        peak_threshold=0.02,
        fit="parabola",  # whose peak is that of the three largest samples
        bits=0,
    )
    direct, indirect = scan(shape, config), scan(shape, replace(config, bounces=3))
    keys = [s.pixels @ [1, 1000] for s in (direct, indirect)]
    _, i, j = np.intersect1d(*keys, return_indices=True)
    assert len(i) > 100
    gained = indirect.intensity[j] - direct.intensity[i]
    assert gained.min() > -1e-3
    place = direct.true_points[i]
    inner = (place[:, 1] < 10) & (place[:, 2] < -8) & (np.abs(place[:, 0]) < 12)
    outer = np.abs(place).max(axis=1) > 17
    assert gained[inner].mean() > 0.01
    assert gained[inner].mean() > 2 * gained[outer].mean()


def test_one_bounce_has_no_indirect_light(plate):
    config = ScannerConfig(views=((0.3, 0.2, 1.0),), resolution=(24, 24), stripes=60, shading="flat")
    rig = Rig(plate, config)
    hits = rig.tracer.view(rig.poses[0])
    swept = stripe.swept_stripes(stripe.laser_coordinates(hits.points, config.baseline), config)
    assert (brute_force.indirect(rig.tracer, rig.poses[0], hits.pixels, swept) == 0).all()

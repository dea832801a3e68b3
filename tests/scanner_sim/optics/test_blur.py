"""Blur over pixels against dense images, and against the width that theory gives."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from scanner_sim import ScannerConfig
from scanner_sim.optics import stripe
from scanner_sim.optics.blur import blurred, kernel
from scanner_sim.optics.measurement import blur_width
from scanner_sim.optics.rows import Rows


def test_kernel_of_the_reference_smoother():
    """Its smoother s has the weights exp(-2 x^2 / s^2): at s = 1, 1 : .1353 : .0003."""
    weights = kernel(0.5)
    assert len(weights) == 5
    assert np.allclose(weights / weights[2], [0.000335, 0.135335, 1, 0.135335, 0.000335], atol=1e-6)
    assert weights.sum() == pytest.approx(1)


def test_rows_are_blurred_like_the_images_of_the_stripes():
    config = ScannerConfig(resolution=(40, 30), smoothing=1.2, stripes=300)
    rng = np.random.default_rng(0)
    place = rng.permutation(40 * 30)[:500]
    pixels = np.stack([place % 40, place // 40], axis=1).astype(np.int32)
    rows = Rows.uniform(stripe.SweptStripes(rng.integers(5, 290, 500), rng.random((500, 6))))
    images = np.zeros((300, 30, 40))
    number, sample = rows.stripes()
    images[sample, pixels[number, 1], pixels[number, 0]] = rows.values
    reach = len(kernel(1.2)) // 2
    expected = gaussian_filter(images, [0, 1.2, 1.2], mode="constant", radius=[0, reach, reach])
    wide = blurred(pixels, rows, config)
    number, sample = wide.stripes()
    assert np.abs(wide.values - expected[sample, pixels[number, 1], pixels[number, 0]]).max() < 1e-12
    total = sum(expected[:, y, x].sum() for x, y in pixels)
    assert wide.values.sum() == pytest.approx(total)


def test_blur_widens_the_peak_of_a_tilted_plane_as_predicted():
    """A blur of sigma pixels adds the variance sigma^2 |grad phi|^2 to that of the peak over time."""
    config = ScannerConfig(resolution=(120, 120), smoothing=2.0, bits=0, stripes=1600)
    column, row = np.meshgrid(np.arange(40, 80), np.arange(40, 80))
    pixels = np.stack([column.ravel(), row.ravel()], axis=1).astype(np.int32)
    rays = np.stack([*((pixels + 0.5 - 60) / config.focal).T, np.ones(len(pixels))], axis=1)
    normal = np.array([0.4, 0.3, -1.0]) / np.linalg.norm([0.4, 0.3, -1.0])
    points = rays * (130 * normal[2] / (rays @ normal))[:, None]
    laser = stripe.laser_coordinates(points, config.baseline)
    rows = blurred(pixels, Rows.uniform(stripe.swept_stripes(laser, config)), config)
    middle = np.flatnonzero((pixels == [60, 60]).all(axis=1))
    values = rows.padded(middle)[0]
    angle = (rows.first[middle][0] + np.arange(len(values))) * config.step
    mean = (values * angle).sum() / values.sum()
    variance = (values * (angle - mean) ** 2).sum() / values.sum()
    cast = Rows.uniform(stripe.swept_stripes(laser, config)).padded(middle)[0]
    bare = np.arange(len(cast)) * config.step
    narrow = (cast * (bare - (cast * bare).sum() / cast.sum()) ** 2).sum() / cast.sum()
    added = blur_width(points[middle], np.tile(normal, (1, 1)), config)[0] ** 2 / 2
    assert variance - narrow == pytest.approx(added, rel=0.03)

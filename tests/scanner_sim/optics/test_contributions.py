"""What a pixel's footprint adds up: mixed pixels at depth edges follow the analytic curve."""

import numpy as np
import pytest

from scanner_sim import ScannerConfig
from scanner_sim.optics import stripe
from scanner_sim.optics.contributions import contributions
from scanner_sim.optics.hits import Hits
from scanner_sim.optics.measurement import measure
from scanner_sim.optics.triangulation import triangulate
from scanner_sim.optics.verdict import Verdict


def two_planes(config, near, far, edge):
    """Rays that hit a plane at depth `near` left of x = edge, and one at `far` (or nothing) right of it."""
    k = config.footprint
    column, row = np.meshgrid(np.arange(180 * k, 220 * k), np.arange(199 * k, 201 * k))
    sub = np.stack([column.ravel(), row.ravel()], axis=1)
    rays = np.stack([*((sub + 0.5) / k - 200).T / config.focal, np.ones(len(sub))], axis=1)
    left = rays[:, 0] * near < edge
    if far is None:
        sub, rays, left = sub[left], rays[left], left[left]
    points = rays * np.where(left, near, far if far else near)[:, None]
    n = len(sub)
    toward = np.array([config.baseline, 0, 0]) - points
    cosine = -toward[:, 2] / np.linalg.norm(toward, axis=1)
    normals = np.tile([0.0, 0.0, -1.0], (n, 1))
    faces = np.where(left, 0, 1).astype(np.int32)
    return Hits((sub // k).astype(np.int32), faces, np.full((n, 3), 1 / 3), points, normals, cosine)


def test_a_pixel_that_a_silhouette_cuts_measures_the_middle_of_its_visible_part():
    """Edge curl: the peak is that of the part that is seen, the ray that of the whole pixel."""
    config = ScannerConfig(
        footprint=15, bits=0, fit="centre_of_mass", views=1, stripes=2000, stripe_width=1.0
    )
    for share in (0.2, 0.5, 0.8):
        pitch = 120 / config.focal
        hits = two_planes(config, 120.0, None, share * pitch)
        found = measure(hits, config, 0, 0)
        pixels = hits.pixels[found.index]
        cut = np.flatnonzero((pixels == [200, 199]).all(axis=1))[0]
        middle = stripe.laser_coordinates(np.array([[share / 2 * pitch, 0.0, 120.0]]), config.baseline).angle
        ray = np.array([[0.5 / config.focal, -0.5 / config.focal, 1.0]])
        expected = triangulate(ray, middle, config.baseline)[0]
        step = abs(triangulate(ray, middle + pitch / 15 / 120, config.baseline)[0, 2] - expected[2])
        assert abs(found.points[cut, 2] - expected[2]) < step
        assert found.peak[cut] == pytest.approx(share * hits.radiance[0], rel=0.1)


def test_flying_points_lie_between_the_depths_of_a_step_in_the_share_of_its_sides():
    config = ScannerConfig(footprint=15, bits=0, fit="centre_of_mass", stripes=2000, stripe_width=2.5)
    near, far = 120.0, 121.0
    depths = []
    shares = np.array([0.2, 0.4, 0.6, 0.8])
    for share in shares:
        hits = two_planes(config, near, far, share * near / config.focal)
        found = measure(hits, config, 0, 0)
        pixels = hits.pixels[found.index]
        cut = np.flatnonzero((pixels == [200, 199]).all(axis=1))[0]
        angles = [
            stripe.laser_coordinates(np.array([[x * d / config.focal, 0.0, d]]), config.baseline).angle[0]
            for x, d in ((share / 2, near), ((1 + share) / 2, far))
        ]
        mixed = np.array([share * angles[0] + (1 - share) * angles[1]])
        ray = np.array([[0.5 / config.focal, -0.5 / config.focal, 1.0]])
        expected = triangulate(ray, mixed, config.baseline)[0, 2]
        assert found.points[cut, 2] == pytest.approx(expected, abs=0.06 * (far - near))
        depths.append(found.points[cut, 2])
    assert (np.diff(depths) < 0).all()  # the more of the near side, the nearer


def test_peaks_far_apart_are_not_mixed_and_the_brighter_one_is_measured():
    config = ScannerConfig(footprint=5, bits=0)
    hits = two_planes(config, 120.0, 150.0, 0.7 * 120 / config.focal)
    lit = contributions(hits, config)
    assert lit.rows > len(np.unique(hits.pixels[:, 0])) * len(np.unique(hits.pixels[:, 1]))
    found = measure(hits, config, 0, 0)
    pixels = hits.pixels[found.index]
    cut = np.flatnonzero((pixels == [200, 199]).all(axis=1))[0]
    assert hits.face_ids[found.index[cut]] == 0
    assert found.points[cut, 2] == pytest.approx(120.0, abs=0.5)
    assert len(np.unique(pixels, axis=0)) == len(pixels)


def test_a_footprint_of_one_ray_is_the_pixel_itself():
    config = ScannerConfig()
    hits = two_planes(config, 120.0, 150.0, 0.0)
    lit = contributions(hits, config)
    assert lit.single
    assert (lit.hit == np.arange(len(hits.pixels))).all()
    assert (lit.amplitude == hits.radiance).all()
    assert (measure(hits, config, 0, 0).verdict == Verdict.ACCEPTED).all()


def test_background_mixes_but_is_not_measured():
    config = ScannerConfig(footprint=5, background=10.0)
    hits = two_planes(config, 120.0, 150.0, 0.0)
    hits.face_ids[hits.face_ids == 1] = -1
    found = measure(hits, config, 0, 0)
    gone = hits.face_ids[found.index] < 0
    assert gone.any()
    assert (found.verdict[gone] == Verdict.MISS).all()

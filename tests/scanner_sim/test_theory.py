"""Lit pixels, residuals and normals against analytic truth and a plain NumPy ray tracer."""

import numpy as np
import pytest

from scanner_sim import ScannerConfig, scan
from scanner_sim.optics import viewpoints
from scanner_sim.optics.camera import camera_rays
from scanner_sim.scanner import Rig
from scanner_sim.tracing.tracer import REFLECTANCE, Tracer, rounded

MARGIN = 0.02
"""Of cosines about the threshold within which quantisation and the stripe's phase decide."""


def whole_image(config):
    column, row = np.meshgrid(np.arange(config.resolution[0]), np.arange(config.resolution[1]))
    return np.stack([column.ravel(), row.ravel()], axis=1)


def accepted_image(found, view, config):
    image = np.zeros(config.resolution[::-1], bool)
    pixels = found.pixels[found.view_ids == view]
    image[pixels[:, 1], pixels[:, 0]] = True
    return image.ravel()


def check_lit_set(shape, config, hit, view=0):
    """`hit` maps eye, laser and rays in mm to: hit, cosine to the laser, certain (no edge case)."""
    found = scan(shape, config)
    pose = viewpoints.poses(viewpoints.directions(config.views, config.up), _distance(shape, config))[view]
    laser = pose[:3, 3] + config.baseline * pose[:3, 0]
    rays = camera_rays(whole_image(config), config) @ pose[:3, :3].T
    seen, cosine, certain = hit(pose[:3, 3], laser, rays)
    expected = seen & (cosine >= config.peak_threshold)
    certain &= np.abs(cosine - config.peak_threshold) > MARGIN
    got = accepted_image(found, view, config)
    assert (got == expected)[certain].all()
    assert expected.sum() > 300
    assert certain.mean() > 0.6
    return found


def _distance(shape, config):
    return config.min_range + np.linalg.norm(np.ptp(shape.vertices, axis=0)) / 2


@pytest.mark.parametrize("threshold", [0.1, 0.6])
def test_lit_pixels_on_a_sphere(fine_sphere, threshold):
    def hit(eye, laser, rays):
        rays = rays / np.linalg.norm(rays, axis=1, keepdims=True)
        along = -rays @ eye
        square = along**2 - eye @ eye + 37.5**2
        points = eye + (along - np.sqrt(np.maximum(square, 0)))[:, None] * rays
        normals = points / 37.5
        toward = laser - points
        cosine = np.einsum("nd,nd->n", normals, toward) / np.linalg.norm(toward, axis=1)
        return square > 0, np.where(square > 0, cosine, -1), np.abs(square) > 10

    check_lit_set(
        fine_sphere,
        ScannerConfig(views=3, resolution=(80, 80), peak_threshold=threshold, fit="least_squares"),
        hit,
        view=1,
    )


def test_lit_pixels_on_a_plane(plate):
    """A plate that leans back: only its large side counts, the rims are left out."""

    def hit(eye, laser, rays):
        points = eye + ((2.5 - eye[2]) / rays[:, 2])[:, None] * rays
        inside = np.abs(points[:, :2]).max(axis=1)
        toward = laser - points
        cosine = toward[:, 2] / np.linalg.norm(toward, axis=1)
        return inside < 37.5, cosine, (inside < 36.5) | (inside > 46)

    config = ScannerConfig(
        views=((0.5, 0.3, 1.0),),
        resolution=(80, 80),
        shading="flat",
        peak_threshold=0.65,
        fit="least_squares",
    )
    check_lit_set(plate, config, hit)


def test_lit_pixels_on_a_cylinder(cylinder):
    def hit(eye, laser, rays):
        flat, start = rays[:, [0, 2]], eye[[0, 2]]
        a, b, c = (flat**2).sum(axis=1), flat @ start, start @ start - 400.0
        square = b**2 - a * c
        points = eye + ((-b - np.sqrt(np.maximum(square, 0))) / a)[:, None] * rays
        normals = points * [1, 0, 1] / 20.0
        toward = laser - points
        cosine = np.einsum("nd,nd->n", normals, toward) / np.linalg.norm(toward, axis=1)
        seen = (square > 0) & (np.abs(points[:, 1]) < 37.5)
        inner = (np.abs(points[:, 1]) < 37) & (np.abs(square) > 0.02 * a * 400)
        outer = (square < -0.02 * a * 400) | (np.abs(points[:, 1]) > 38)
        return seen, np.where(square > 0, cosine, -1), inner | outer

    config = ScannerConfig(
        views="ring:3", resolution=(80, 80), shading="flat", peak_threshold=0.4, fit="least_squares"
    )
    check_lit_set(cylinder, config, hit, view=1)


def first_hits(corners, origins, rays):
    """Nearest triangle of each ray by testing all [Möller & Trumbore 1997]: index (-1: none), depth."""
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    index, depth = np.full(len(rays), -1), np.full(len(rays), np.inf)
    for k in range(len(corners)):
        p = np.cross(rays, e2[k])
        det = p @ e1[k]
        det = np.where(np.abs(det) < 1e-12, np.nan, det)
        s = origins - a[k]
        u = np.einsum("nd,nd->n", s, p) / det
        q = np.cross(s, e1[k])
        v = np.einsum("nd,nd->n", rays, q) / det
        t = (q @ e2[k]) / det
        ok = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-5) & (t < depth)
        index[ok], depth[ok] = k, t[ok]
    return index, depth


def test_traced_faces_cosines_and_shadows_equal_a_plain_ray_tracer(torus, each_variant):
    config = ScannerConfig(views=((1, 0, 0.3), (0.3, 1, 0.5)), resolution=(48, 48), shading="flat")
    tracer = Tracer(torus, config)
    rig = Rig(torus, config)
    corners = tracer.vertices[torus.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    shadowed = 0
    for pose in rig.poses:
        rays = camera_rays(whole_image(config), config) @ pose[:3, :3].T
        index, depth = first_hits(corners, np.broadcast_to(pose[:3, 3], rays.shape), rays)
        front = (index >= 0) & (np.einsum("nd,nd->n", normals[index], rays) < 0)
        hits = tracer.view(pose)
        number = hits.pixels[:, 1] * 48 + hits.pixels[:, 0]
        assert len(np.setxor1d(number, np.flatnonzero(front))) <= 0.01 * front.sum()
        same = index[number] == hits.face_ids
        assert same.mean() > 0.99
        points = pose[:3, 3] + depth[number][same, None] * rays[number][same]
        traced = hits.points[same] @ pose[:3, :3].T + pose[:3, 3]
        assert np.abs(points - traced).max() < 1e-3
        toward = pose[:3, 3] + config.baseline * pose[:3, 0] - points
        cosine = np.einsum("nd,nd->n", normals[hits.face_ids[same]], toward) / np.linalg.norm(toward, axis=1)
        blocked = first_hits(corners, points + 1e-4 * toward, toward)[1] < 1
        expected = np.where(blocked, 0, np.maximum(cosine, 0))
        shadowed += (blocked & (cosine > 0)).sum()
        assert (np.abs(hits.radiance[same] - expected) < 1e-4).mean() > 0.99
    assert shadowed > 20


@pytest.mark.parametrize("fit", ["least_squares", "gaussian"])
def test_residual_and_normals_on_a_fine_sphere_beat_the_reference(fine_sphere, fit):
    """Reference: residual 0.0023 mm RMS, normals off by 0.27 degrees on average."""
    found = scan(fine_sphere, ScannerConfig(views=3, fit=fit, normals="pca"))
    radius = np.linalg.norm(found.points, axis=1)
    assert np.sqrt(((radius - 37.5) ** 2).mean()) < 0.0023
    outward = found.true_points / np.linalg.norm(found.true_points, axis=1, keepdims=True)
    error = np.degrees(np.arccos(np.clip(np.einsum("nd,nd->n", found.normals, outward), -1, 1)))
    assert error.mean() < 0.27


@pytest.mark.parametrize("name", ["plate", "cylinder"])
def test_residual_on_flat_and_curved_surfaces(name, request):
    shape = request.getfixturevalue(name)
    found = scan(shape, ScannerConfig(views=6, resolution=(200, 200), shading="flat"))
    gap = np.einsum("nd,nd->n", found.points - found.true_points, found.normals)
    assert np.sqrt((gap**2).mean()) < 0.0046  # half the reference's resolution, so twice its residual


def test_residual_shrinks_with_the_peak(fine_sphere):
    """Quantisation noise over peak: brighter pixels are measured better, about in proportion."""
    found = scan(fine_sphere, ScannerConfig(views=3, resolution=(200, 200)))
    gap = np.linalg.norm(found.points - found.true_points, axis=1)
    dim, bright = found.intensity < 0.25, found.intensity > 0.85
    assert np.sqrt((gap[dim] ** 2).mean()) > 3 * np.sqrt((gap[bright] ** 2).mean())


def test_without_quantisation_and_noise_points_are_exact(sphere):
    found = scan(sphere, ScannerConfig(views=2, resolution=(100, 100), bits=0, fit="least_squares"))
    assert np.abs(found.points - found.true_points).max() < 2e-4


def test_radiance_of_single_precision_becomes_that_of_double():
    """Of reflectances that are multiples of the step, nothing of the error is left."""
    rng = np.random.default_rng(0)
    cosine, reflectance = rng.uniform(0.01, 1, 4000), np.repeat([1.0, 0.5, 0.05, 2.3], 1000)
    exact = reflectance * cosine
    single = exact.astype(np.float32).astype(np.float64)
    assert np.abs(single - exact).max() > 1e-8
    assert np.allclose(rounded(single, cosine), exact, rtol=1e-14, atol=0)
    glossy = rng.uniform(0, 3, 4000) * cosine
    assert (np.abs(rounded(glossy, cosine) - glossy) <= 0.5001 * REFLECTANCE * cosine).all()


def test_what_is_in_shadow_stays_dark_and_what_looks_away_stays():
    radiance = np.array([0.0, 0.0, 0.3, 1e-9])
    assert rounded(radiance, np.array([0.5, -0.5, -0.1, 0.5])).tolist() == [0.0, 0.0, 0.3, 0.0]

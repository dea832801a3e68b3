"""Whole scans against the sphere's analytic truth and the reference's figures."""

from dataclasses import replace

import numpy as np
import pytest

from datasets_gen import Shape
from scanner_sim import Scan, ScannerConfig, coverage, sample, scan


@pytest.fixture(scope="module")
def sphere_scan(sphere):
    """Fitted by least squares: the reference's fit is compared with its program in `test_reference`."""
    return scan(sphere, ScannerConfig(views=9, fit="least_squares"))


def test_residual_is_at_most_the_references(sphere, sphere_scan):
    residual = np.einsum("nd,nd->n", sphere_scan.points - sphere_scan.true_points, sphere_scan.normals)
    assert np.sqrt((residual**2).mean()) < 0.0023
    assert np.abs(residual.mean()) < 2e-4


def test_true_points_lie_where_the_pixel_looks(sphere, sphere_scan):
    """Project the true points back: they land on the centres of their pixels."""
    config = sphere_scan.config
    poses = sphere_scan.poses[sphere_scan.view_ids]
    local = np.einsum("nji,nj->ni", poses[:, :3, :3], sphere_scan.true_points - poses[:, :3, 3])
    image = local[:, :2] / local[:, 2:] * config.focal + np.array(config.resolution) / 2
    assert np.abs(image - sphere_scan.pixels - 0.5).max() < 0.02


def test_normals_are_unit_and_outward(sphere_scan):
    assert np.allclose(np.linalg.norm(sphere_scan.normals, axis=1), 1)
    outward = sphere_scan.true_points / np.linalg.norm(sphere_scan.true_points, axis=1, keepdims=True)
    assert np.einsum("nd,nd->n", sphere_scan.normals, outward).min() > 0.999


@pytest.mark.parametrize(("tau", "reference"), [(0.5, 0.998), (0.7, 0.835), (0.9, 0.281)])
def test_coverage_per_threshold_is_near_the_references(sphere, sphere_scan, tau, reference):
    assert coverage(sphere_scan.accept(tau), sphere) == pytest.approx(reference, abs=0.035)


def test_peak_is_the_cosine_to_the_laser(sphere_scan):
    """Noise-free on a white diffuse surface, up to quantisation."""
    config, poses = sphere_scan.config, sphere_scan.poses[sphere_scan.view_ids]
    laser = poses[:, :3, 3] + config.baseline / sphere_scan.scale * poses[:, :3, 0]
    toward = laser - sphere_scan.true_points
    cosine = np.einsum("nd,nd->n", sphere_scan.normals, toward) / np.linalg.norm(toward, axis=1)
    assert np.abs(sphere_scan.intensity - cosine).max() < 4 / 255


def test_accept_equals_scanning_at_the_threshold(capsule):
    low = scan(capsule, ScannerConfig(views=4, peak_threshold=0.05, noise=0.1, resolution=(120, 120)), seed=3)
    high = scan(capsule, ScannerConfig(views=4, peak_threshold=0.6, noise=0.1, resolution=(120, 120)), seed=3)
    swept = low.accept(0.6)
    assert len(swept) == len(high) > 100
    assert np.array_equal(swept.points, high.points)
    assert swept.config == high.config


def test_scan_does_not_depend_on_units_or_place(capsule):
    config = ScannerConfig(views=4, resolution=(120, 120))
    moved = Shape(
        capsule.vertices * 1e-3 + [5.0, -2.0, 1.0], capsule.faces, "test/moved", "test", "moved", "m"
    )
    a, b = scan(capsule, config), scan(moved, config)
    assert abs(len(a) - len(b)) <= 0.001 * len(a)
    keys = [s.view_ids * 10**6 + s.pixels @ [1000, 1] for s in (a, b)]
    shared, i, j = np.intersect1d(*keys, return_indices=True)
    assert len(shared) > 0.999 * len(a)
    assert np.abs(a.points[i] * 1e-3 + [5.0, -2.0, 1.0] - b.points[j]).max() < 1e-3 * 0.2


def test_same_seed_same_scan_other_seed_other_noise(capsule):
    config = ScannerConfig(views=2, resolution=(100, 100), noise=0.2)
    a, b, c = scan(capsule, config, seed=1), scan(capsule, config, seed=1), scan(capsule, config, seed=2)
    assert np.array_equal(a.points, b.points)
    quiet = scan(capsule, replace(config, noise=0.0))
    keys = [each.view_ids * 10**6 + each.pixels @ [1000, 1] for each in (quiet, a, c)]
    shared = np.array(sorted(set(keys[0]) & set(keys[1]) & set(keys[2])))
    at = [key.argsort()[np.searchsorted(np.sort(key), shared)] for key in keys]
    taken = [each.intensity[k] - quiet.intensity[at[0]] for each, k in ((a, at[1]), (c, at[2]))]
    assert len(shared) > 1000
    assert min(np.abs(each).max() for each in taken) > 0.1
    assert abs(np.corrcoef(taken)[0, 1]) < 0.3  # bright pixels have more to lose, in both


def test_saved_scan_comes_back(capsule, tmp_path):
    before = scan(capsule, ScannerConfig(views=((1, 0, 0), (0, 0, 1)), resolution=(60, 60)), seed=7)
    before.save(tmp_path / "scan.npz")
    after = Scan.load(tmp_path / "scan.npz")
    assert np.array_equal(after.points, before.points)
    assert np.array_equal(after.poses, before.poses)
    assert (after.config, after.seed, after.scale) == (before.config, 7, before.scale)
    assert after.variant == before.variant != ""


def test_ideal_sample_is_complete_even_and_exact(capsule):
    ideal = sample(capsule, 3000, seed=1)
    assert len(ideal) == 3000
    assert np.allclose(capsule.at(ideal.face_ids, ideal.barycentrics), ideal.points)
    assert coverage(ideal, capsule, radius=2.2 * np.sqrt(capsule.area / 3000)) == 1
    assert (ideal.view_ids == -1).all()
    assert (ideal.intensity == 1).all()

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from datasets_gen import InputError
from datasets_gen.points import normals
from scanner_sim import ScannerConfig, estimated_normals, sample, scan
from scanner_sim import view_alignment as registration
from tests.scanner_sim.conftest import to_shape


def fibonacci_sphere(n):
    i = np.arange(n) + 0.5
    z, angle = 1 - 2 * i / n, np.pi * (1 + 5**0.5) * i
    r = np.sqrt(1 - z**2)
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)


def test_pca_equals_the_singular_vectors_of_each_neighbourhood():
    points = np.random.default_rng(0).normal(size=(300, 3)) * [1, 1, 0.05]
    found = normals.pca(points, 12)
    for i in range(0, 300, 23):
        order = np.argsort(np.linalg.norm(points - points[i], axis=1))[:13]
        _, _, axes = np.linalg.svd(points[order] - points[order].mean(axis=0))
        assert abs(found[i] @ axes[2]) == pytest.approx(1)


def test_pca_is_exact_on_a_plane_and_turns_with_the_points():
    rng = np.random.default_rng(1)
    points = np.c_[rng.random((200, 2)), np.zeros(200)]
    assert np.allclose(np.abs(normals.pca(points)), [0, 0, 1])
    turn = Rotation.random(random_state=2)
    cloud = rng.normal(size=(200, 3))
    turned = normals.pca(turn.apply(cloud))
    assert np.allclose(np.abs(np.einsum("nd,nd->n", turned, turn.apply(normals.pca(cloud)))), 1)


def test_scanner_sign_points_to_the_eye():
    points = fibonacci_sphere(500)
    flipped = points * np.where(np.arange(500) % 2, 1, -1)[:, None]
    eyes = 5 * points + [0.1, 0, 0]
    assert np.allclose(normals.toward(flipped, points, eyes), points)


def test_spanning_tree_makes_signs_consistent_and_outward():
    points = np.concatenate([fibonacci_sphere(2000), fibonacci_sphere(1000) + np.array([5, 0, 0])])
    outward = points - np.where(np.arange(3000)[:, None] < 2000, [0, 0, 0], [5, 0, 0])
    random = outward * np.random.default_rng(3).choice([-1, 1], 3000)[:, None]
    assert np.allclose(normals.spanning_tree(points, random), outward)


def test_views_are_estimated_apart():
    """A shifted second view must not bend the normals of the first."""
    rng = np.random.default_rng(4)
    plane = np.c_[rng.random((400, 2)), np.zeros(400)]
    views = np.repeat([0, 1], 200)
    cloud = plane + np.where(views == 1, 0.05, 0)[:, None] * [0, 0, 1]
    assert np.allclose(np.abs(normals.pca_by_view(cloud, views)), [0, 0, 1])
    assert not np.allclose(np.abs(normals.pca(cloud)), [0, 0, 1], atol=1e-3)


def test_views_with_few_points_borrow_from_the_others():
    rng = np.random.default_rng(5)
    plane = np.c_[rng.random((100, 2)), np.zeros(100)]
    views = np.r_[np.zeros(97, int), np.full(3, 7)]
    assert np.allclose(np.abs(normals.pca_by_view(plane, views)), [0, 0, 1])


def test_too_few_points_are_refused():
    with pytest.raises(InputError, match="too few"):
        normals.pca(np.zeros((5, 3)), 12)


@pytest.mark.parametrize("kind", ["pca", "mst"])
def test_scans_with_estimated_normals(sphere, kind):
    found = scan(sphere, ScannerConfig(views=8, resolution=(120, 120), normals=kind))
    outward = found.true_points / 37.5
    cosine = np.einsum("nd,nd->n", found.normals, outward)
    assert (cosine > 0).mean() > 0.999
    assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean() < 2.0


def test_estimation_on_a_thinned_scan(sphere):
    found = scan(sphere, ScannerConfig(views=8, resolution=(120, 120))).accept(0.4).subsample(4000)
    for kind in ("pca", "mst"):
        cosine = np.einsum("nd,nd->n", estimated_normals(found, kind), found.true_points / 37.5)
        assert (cosine > 0.9).mean() > 0.99
    with pytest.raises(InputError, match="viewpoints"):
        estimated_normals(sample(sphere, 500), "pca")
    with pytest.raises(InputError, match="'pcb'"):
        estimated_normals(found, "pcb")


def test_registration_error_turns_each_view_rigidly_about_its_centroid():
    rng = np.random.default_rng(6)
    points, views = rng.normal(size=(600, 3)), np.repeat([0, 1, 5], 200)
    moved = registration.disturb(points, views, 2.0, seed=3)
    axes = []
    for view in (0, 1, 5):
        a, b = points[views == view], moved[views == view]
        assert np.allclose(a.mean(axis=0), b.mean(axis=0))
        turn, _ = Rotation.align_vectors(b - b.mean(axis=0), a - a.mean(axis=0))
        assert turn.magnitude() == pytest.approx(np.radians(2.0))
        assert np.allclose(turn.apply(a - a.mean(axis=0)), b - b.mean(axis=0))
        axes.append(turn.as_rotvec())
    assert not np.allclose(axes[0], axes[1])
    assert np.array_equal(moved, registration.disturb(points, views, 2.0, seed=3))
    assert not np.allclose(moved, registration.disturb(points, views, 2.0, seed=4))


def test_realignment_repairs_most_of_the_registration_error():
    """On an ellipsoid, whose shape tells the views' places; up to where the whole lies in space."""
    mesh = trimesh.creation.icosphere(subdivisions=5)
    mesh.apply_scale([37.5, 25, 15])
    ellipsoid = to_shape(mesh)
    gap = {}
    for realign in (False, True):
        config = ScannerConfig(views=8, resolution=(120, 120), registration_error=1.5, realign=realign)
        found = scan(ellipsoid, config, seed=2)
        options = {"reflection": False, "scale": False}
        _, placed, _ = trimesh.registration.procrustes(found.points, found.true_points, **options)
        normal = found.true_points / np.array([37.5, 25, 15]) ** 2
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        gap[realign] = np.sqrt((np.einsum("nd,nd->n", placed - found.true_points, normal) ** 2).mean())
    assert gap[True] < 0.35 * gap[False]


def test_realignment_leaves_a_single_view_alone():
    points = np.random.default_rng(7).normal(size=(100, 3))
    assert np.array_equal(registration.realign(points, np.zeros(100, int), 0), points)

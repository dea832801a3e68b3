import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from scanner_sim import ScannerConfig, scan, view_alignment
from tests.scanner_sim.conftest import to_shape


def test_registration_error_turns_each_view_rigidly_about_its_centroid():
    rng = np.random.default_rng(6)
    points, views = rng.normal(size=(600, 3)), np.repeat([0, 1, 5], 200)
    moved = view_alignment.disturb(points, views, 2.0, seed=3)
    axes = []
    for view in (0, 1, 5):
        a, b = points[views == view], moved[views == view]
        assert np.allclose(a.mean(axis=0), b.mean(axis=0))
        turn, _ = Rotation.align_vectors(b - b.mean(axis=0), a - a.mean(axis=0))
        assert turn.magnitude() == pytest.approx(np.radians(2.0))
        assert np.allclose(turn.apply(a - a.mean(axis=0)), b - b.mean(axis=0))
        axes.append(turn.as_rotvec())
    assert not np.allclose(axes[0], axes[1])
    assert np.array_equal(moved, view_alignment.disturb(points, views, 2.0, seed=3))
    assert not np.allclose(moved, view_alignment.disturb(points, views, 2.0, seed=4))


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
    assert np.array_equal(view_alignment.realign(points, np.zeros(100, int), 0), points)

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from datasets_gen import InputError
from datasets_gen.points import normals


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


def test_sign_of_a_piece_is_that_of_the_sum_over_its_points():
    """On a bowl seen from both sides no single point tells outward: the piece as a whole does."""
    points = np.random.default_rng(8).normal(size=(400, 3)) * [1, 1, 0.02]
    points[:, 2] += 0.3 * (points[:, :2] ** 2).sum(axis=1)
    found = normals.spanning_tree(points, normals.pca(points))
    away = points - points.mean(axis=0)
    assert np.einsum("nd,nd->", away, found) > 0
    assert np.array_equal(normals.spanning_tree(points, -normals.pca(points)), found)


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

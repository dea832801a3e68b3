from itertools import product

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


@pytest.mark.uncompiled
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


@pytest.mark.uncompiled
def test_signs_elected_on_a_tree_are_the_best_of_all():
    rng = np.random.default_rng(6)
    every = np.array(list(product([-1.0, 1.0], repeat=9)))
    for stiffness in (0.1, 0.5, 2.0):
        for _ in range(20):
            parents = np.array([rng.integers(i) for i in range(1, 9)])
            votes = rng.uniform(-1, 1, 9)

            def gain(signs, parents=parents, votes=votes, stiffness=stiffness):
                return signs @ votes / 2 - stiffness * (signs[..., 1:] != signs[..., parents]).sum(axis=-1)

            found = normals._elected(parents, votes, stiffness)
            assert gain(found) == pytest.approx(gain(every).max())


def test_eyes_decide_the_side_of_what_has_no_inside():
    """A sheet and a bowl seen from above: their volumes about the centroid say nothing or the opposite."""
    rng = np.random.default_rng(7)
    sheet = np.c_[rng.random((400, 2)), np.zeros(400)]
    bowl = sheet + [5, 0, 0] + np.c_[np.zeros((400, 2)), ((sheet[:, :2] - 0.5) ** 2).sum(axis=1)]
    points = np.concatenate([sheet, bowl])
    eyes = np.broadcast_to([2.0, 0.0, 50.0], points.shape)
    for sign in (1, -1):
        found = normals.spanning_tree(points, sign * normals.pca(points), eyes=eyes)
        assert (found[:, 2] > 0).all()


def test_an_end_beyond_a_bad_bridge_is_turned_by_its_own_votes():
    """Two spheres joined by a thread of points without sound normals."""
    rng = np.random.default_rng(9)
    ball = fibonacci_sphere(1500)
    thread = np.linspace([1.02, 0, 0], [2.98, 0, 0], 60) + rng.normal(scale=0.01, size=(60, 3))
    points = np.concatenate([ball, ball + np.array([4, 0, 0]), thread])
    outward = np.concatenate([ball, ball, thread * [0, 1, 1]])
    eyes = 20 * outward / np.linalg.norm(outward, axis=1, keepdims=True) + [2, 0, 0]
    for seed in range(6):
        guess = normals.pca(points) * np.random.default_rng(seed).choice([-1, 1], len(points))[:, None]
        found = normals.spanning_tree(points, guess, eyes=eyes)
        right = np.einsum("nd,nd->n", found, outward)[:3000] > 0
        assert right.mean() > 0.999

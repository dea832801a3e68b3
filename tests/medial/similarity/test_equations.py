"""Eqs. 4-7 against closed forms, sums written out, and the definition of the candidate ball."""

from math import exp, sqrt

import numpy as np
import pytest

from medial.similarity.equations import (
    candidate_balls,
    depth_in_ball,
    medial_similarity,
    normal_deviation,
    similarity_matrix,
    summed_depth,
)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def pairs(count, seed=0, size=0.3):
    """Random oriented pairs of points, nearer to each other than 1."""
    random = np.random.default_rng(seed)
    p, q = random.normal(size=(2, count, 3)) * size
    return p, q, unit(random.normal(size=(count, 3))), unit(random.normal(size=(count, 3)))


def misfit(center, p, q, n, m):
    """Least squares of the normals at two points against those of a ball through both."""
    return ((n - unit(p - center)) ** 2).sum(-1) + ((m - unit(q - center)) ** 2).sum(-1)


def test_the_candidate_ball_touches_both_points_and_no_other_fits_the_normals_better():
    p, q, n, m = pairs(200)
    with np.errstate(all="raise"):
        centers, radii = candidate_balls(p, q, n, m)
    there = radii > 0
    assert (there == (((n - m) * (p - q)).sum(axis=1) > 0)).all()
    assert not centers[~there].any()
    p, q, n, m, centers, radii = (each[there] for each in (p, q, n, m, centers, radii))
    assert np.linalg.norm(centers - p, axis=1) == pytest.approx(radii)
    assert np.linalg.norm(centers - q, axis=1) == pytest.approx(radii)
    along = unit(p - q)
    for size in (1e-3, 0.1, 2.0):
        step = size * np.random.default_rng(1).normal(size=centers.shape) * radii[:, None]
        step -= (step * along).sum(axis=1, keepdims=True) * along  # within the bisector plane
        assert (misfit(centers, p, q, n, m) <= misfit(centers + step, p, q, n, m) + 1e-12).all()


def test_points_of_a_sphere_suggest_the_sphere():
    normals = unit(np.random.default_rng(0).normal(size=(2, 30, 3)))
    points = 4 + 0.5 * normals
    with np.errstate(all="raise"):
        centers, radii = candidate_balls(*points, *normals)
    assert centers == pytest.approx(np.full((30, 3), 4))
    assert radii == pytest.approx(np.full(30, 0.5))
    assert normal_deviation(*points, *normals, centers, radii) == pytest.approx(np.zeros(30), abs=1e-9)


@pytest.mark.parametrize(
    ("n", "m"),
    [([0, 0, -1], [0, 0, 1]), ([0, 0, 1], [0, 0, 1]), ([1, 0, 0], [-1, 0, 0])],
    ids=["inward", "parallel", "sideways"],
)
def test_no_ball_where_the_normals_do_not_part(n, m):
    top, bottom = np.array([0, 0, 0.1]), np.array([0, 0, -0.1])
    with np.errstate(all="raise"):
        centers, radii = candidate_balls(top, bottom, np.array(n, float), np.array(m, float))
        assert radii == 0
        assert (centers == 0).all()
        assert candidate_balls(top, top, np.array(n, float), np.array(m, float))[1] == 0


@pytest.mark.parametrize(("angle", "radius"), [(1e-3, 1.0), (1e-8, 0.0)])
def test_no_ball_where_the_normals_are_all_but_tangent_to_the_bisector_plane(angle, radius):
    """Normals at +x and -x that lean outward by an angle t, up and down: F = 2 sin t, the unit ball."""
    n = np.array([np.sin(angle), np.cos(angle), 0])
    centers, radii = candidate_balls(np.array([1.0, 0, 0]), np.array([-1.0, 0, 0]), n, -n)
    assert radii == pytest.approx(radius, rel=1e-6)
    assert centers == pytest.approx(np.zeros(3), abs=1e-9)


def test_deviation_of_the_normals_term_by_term():
    """Eq. 4, with any balls."""
    p, q, n, m = pairs(20)
    random = np.random.default_rng(2)
    centers, radii = random.normal(size=(20, 3)), random.uniform(0.2, 3, 20)
    written = [
        sqrt(sum((n[i] - (p[i] - centers[i]) / radii[i]) ** 2))
        + sqrt(sum((m[i] - (q[i] - centers[i]) / radii[i]) ** 2))
        for i in range(20)
    ]
    assert normal_deviation(p, q, n, m, centers, radii) == pytest.approx(written)


def test_depth_falls_with_the_fourth_power():
    """Eq. 6: 1 - (1/2)^4 half-way out; 0 on the sphere and beyond."""
    center, radius = np.array([1.0, -2, 0.5]), np.array(0.4)
    away = np.array([0, 0.2, 0.3, 0.4, 0.5])
    points = center + away[:, None] * [2 / 3, -1 / 3, 2 / 3]
    found = depth_in_ball(center, radius, points)
    assert found == pytest.approx([1, 15 / 16, 1 - 0.75**4, 0, 0])
    assert found[-1] == 0


def cloud(n=9, seed=0):
    """A small noisy sphere, so that balls differ and hold points; its normals differ from the radii."""
    random = np.random.default_rng(seed)
    normals = unit(random.normal(size=(n, 3)))
    points = normals * random.uniform(0.6, 1, (n, 1)) + 3
    return points, unit(normals + 0.15 * random.normal(size=(n, 3)))


def test_depths_are_summed_over_the_points():
    """Eq. 5, with and without weights."""
    points, _ = cloud()
    random = np.random.default_rng(3)
    centers, radii, weights = random.normal(3, 0.2, (4, 3)), random.uniform(0.5, 1, 4), random.uniform(size=9)
    depths = np.zeros((4, 9))
    for k in range(4):
        for i in range(9):
            share = np.linalg.norm(points[i] - centers[k]) / radii[k]
            depths[k, i] = max(1 - share**4, 0)
    assert 5 < (depths > 0).sum() < 31
    assert summed_depth(centers, radii, points) == pytest.approx(depths.sum(axis=1))
    assert summed_depth(centers, radii, points, weights) == pytest.approx((depths * weights).sum(axis=1))


def test_similarity_falls_to_one_over_e_at_each_tolerance():
    """Eq. 7; the paper's tolerances are 5 points and 0.7."""
    assert medial_similarity(np.array(0.0), np.array(0.0)) == 1
    assert medial_similarity(np.array(5.0), np.array(0.0)) == pytest.approx(exp(-1))
    assert medial_similarity(np.array(0.0), np.array(0.7)) == pytest.approx(exp(-1))
    assert medial_similarity(np.array(6.0), np.array(1.0), 3.0, 0.5) == pytest.approx(exp(-4 - 4))
    assert medial_similarity(np.array(3.0), np.array(1.5), 2.0, 3.0) == pytest.approx(exp(-2.25 - 0.25))


def written_matrix(points, normals, sigma_e=5.0, sigma_t=0.7, weights=None):
    """Eqs. 4-7 one pair after the other, and the radii of the balls."""
    n = len(points)
    phi, sizes = np.zeros((n, n)), np.zeros((n, n))
    weights = np.ones(n) if weights is None else weights
    for i in range(n):
        for j in range(n):
            center, radius = candidate_balls(points[i], points[j], normals[i], normals[j])
            if i == j or radius == 0:
                continue
            tau = sum(np.linalg.norm(normals[k] - (points[k] - center) / radius) for k in (i, j))
            gamma = sum(
                weights[k] * max(1 - (np.linalg.norm(points[k] - center) / radius) ** 4, 0) for k in range(n)
            )
            phi[i, j], sizes[i, j] = exp(-((gamma / sigma_e) ** 2)) * exp(-((tau / sigma_t) ** 2)), radius
    return phi, sizes


def test_matrix_holds_every_pair_once_in_each_direction():
    points, normals = cloud()
    written, _ = written_matrix(points, normals)
    assert similarity_matrix(points, normals) == pytest.approx(written)
    assert ((written > 0.01) & (written < 0.9)).sum() > 20
    assert (similarity_matrix(points, normals) == similarity_matrix(points, normals).T).all()
    weights = np.random.default_rng(4).uniform(0, 2, len(points))
    written, _ = written_matrix(points, normals, 2.0, 1.3, weights)
    assert similarity_matrix(points, normals, 2.0, 1.3, weights=weights) == pytest.approx(written)


def test_matrix_without_small_values_and_large_balls():
    """Both limits belong to what is kept."""
    points, normals = cloud()
    written, sizes = written_matrix(points, normals)
    cap = np.median(sizes[sizes > 0])
    assert similarity_matrix(points, normals, r_cap=cap * (1 + 1e-9)) == pytest.approx(
        np.where(sizes <= cap, written, 0)
    )
    least = np.sort(similarity_matrix(points, normals)[written > 0])[20]
    found = similarity_matrix(points, normals, cutoff=least)
    assert found.min(where=found > 0, initial=1) == least
    assert found.min() == 0
    assert (found > 0).sum() == (similarity_matrix(points, normals) >= least).sum()
    one = unit(np.array([[1.0, 0, 0], [-1, 0, 0]]))
    assert similarity_matrix(one, one, r_cap=1.0) == pytest.approx(np.array([[0, 1], [1, 0]]))

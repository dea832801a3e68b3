from itertools import product

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from medial.similarity.candidate_ball import candidate_ball, columns, smallest_width
from medial.similarity.equations import candidate_balls, normal_deviation
from tests.medial import clouds

pytestmark = pytest.mark.uncompiled


def ball(p, q, n, m):
    points, normals = np.array([p, q], float), np.array([n, m], float)
    x, y, z, r, f = candidate_ball(*columns(points), *columns(normals), 0, 1)
    return np.array([x, y, z]), r, f


def test_every_pair_of_a_sphere_has_its_center():
    points, normals = clouds.sphere(60, radius=2.5)
    for j in range(1, 60):
        center, radius, tangency = ball(points[0] + 7, points[j] + 7, normals[0], normals[j])
        assert center == pytest.approx([7, 7, 7], abs=1e-9)
        assert radius == pytest.approx(2.5)
        assert tangency == pytest.approx(2)


def test_opposite_points_of_a_cylinder_have_a_ball_on_the_axis():
    center, radius, tangency = ball([0.3, 0, 1], [-0.3, 0, 1], [1, 0, 0], [-1, 0, 0])
    assert center == pytest.approx([0, 0, 1])
    assert (radius, tangency) == (pytest.approx(0.3), pytest.approx(2))


def test_points_on_parallel_planes():
    """Facing points have the ball between the planes; offset ones a larger, tilted one."""
    assert ball([0, 0, 0.1], [0, 0, -0.1], [0, 0, 1], [0, 0, -1])[1:] == (
        pytest.approx(0.1),
        pytest.approx(2),
    )
    center, radius, tangency = ball([0.3, 0, 0.1], [-0.3, 0, -0.1], [0, 0, 1], [0, 0, -1])
    assert center == pytest.approx([0, 0, 0], abs=1e-12)
    assert radius == pytest.approx(np.hypot(0.3, 0.1))
    assert tangency == pytest.approx(2 * 0.1 / radius)


@pytest.mark.parametrize(
    ("n", "m"),
    [([0, 0, -1], [0, 0, 1]), ([0, 0, 1], [0, 0, 1]), ([1, 0, 0], [1, 0, 0])],
    ids=["inward", "same", "across"],
)
def test_no_ball_where_the_normals_forbid_it(n, m):
    assert ball([0, 0, 0.1], [0, 0, -0.1], n, m)[1] == 0


def test_no_ball_for_coinciding_points():
    assert ball([1, 2, 3], [1, 2, 3], [0, 0, 1], [0, 1, 0])[1] == 0


numbers = st.floats(-1, 1).filter(lambda x: abs(x) > 1e-3)


@settings(max_examples=60, deadline=None)
@given(st.lists(numbers, min_size=12, max_size=12))
def test_ball_touches_both_points_and_tau_is_twice_each_term(values):
    p, q, n, m = np.array(values).reshape(4, 3)
    n, m = n / np.linalg.norm(n), m / np.linalg.norm(m)
    center, radius, tangency = ball(p, q, n, m)
    written = candidate_balls(p, q, n, m)
    assert (radius == 0) == (written[1] == 0)
    assume(0 < radius <= 100)
    assert np.linalg.norm(center - p) == pytest.approx(radius, rel=1e-6)
    assert np.linalg.norm(center - q) == pytest.approx(radius, rel=1e-6)
    assert normal_deviation(p, q, n, m, center, np.array(radius)) == pytest.approx(
        2 * np.sqrt(max(2 - tangency, 0)), abs=1e-5
    )
    assert (center, radius) == (pytest.approx(written[0]), pytest.approx(written[1]))


@settings(max_examples=30, deadline=None)
@given(st.lists(numbers, min_size=12, max_size=12), st.integers(0, 99))
def test_no_center_on_the_bisector_agrees_better_with_the_normals(values, seed):
    p, q, n, m = np.array(values).reshape(4, 3)
    n, m = n / np.linalg.norm(n), m / np.linalg.norm(m)
    center, radius, _ = ball(p, q, n, m)
    assume(0 < radius <= 100)

    def misfit(c):
        r = np.linalg.norm(p - c)
        return ((n - (p - c) / r) ** 2).sum() + ((m - (q - c) / r) ** 2).sum()

    random = np.random.default_rng(seed)
    for size in (0.01, 0.1, 1.0):
        step = size * radius * random.standard_normal(3)
        step -= (step @ (p - q)) / ((p - q) @ (p - q)) * (p - q)
        assert misfit(center) <= misfit(center + step) + 1e-9


def test_smallest_width_is_that_of_the_narrowest_axis():
    box = np.array(list(product([-1.5, 1.5], [-1, 1], [-0.1, 0.1])))
    assert smallest_width(box @ clouds.rotation().T + 5) == pytest.approx(0.2)

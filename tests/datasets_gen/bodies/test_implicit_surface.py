import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from datasets_gen.bodies.implicit_surface import (
    Body,
    ellipsoid,
    part_axes,
    radial_distance,
    smooth_min,
    sweep,
    unit,
)

finite = st.floats(-1, 1)
blends = st.floats(1e-3, 0.5)


@pytest.mark.uncompiled
@settings(deadline=None)
@given(finite, finite, blends)
def test_smooth_minimum_is_symmetric_below_the_minimum_and_sharp_outside_the_blend(a, b, blend):
    value = smooth_min(a, b, blend)
    assert value == pytest.approx(smooth_min(b, a, blend))
    assert min(a, b) - blend / 4 - 1e-12 <= value <= min(a, b) + 1e-12
    if abs(a - b) >= blend:
        assert value == pytest.approx(min(a, b))


@pytest.mark.uncompiled
@settings(deadline=None)
@given(st.tuples(finite, finite, finite).filter(lambda p: np.linalg.norm(p) > 1e-3), st.floats(0.1, 2))
def test_distance_to_a_sphere_is_exact(point, radius):
    found = radial_distance(*point, radius, radius, radius, 2.0)
    assert found == pytest.approx(np.linalg.norm(point) - radius, abs=1e-9)


def slow_radial_distance(point, radii, power):
    """(k - 1) / |grad k| with the gradient of k by finite differences."""

    def k(p):
        return (np.abs(p / radii) ** power).sum() ** (1 / power)

    step = 1e-6
    slope = [(k(point + step * e) - k(point - step * e)) / (2 * step) for e in np.eye(3)]
    return (k(point) - 1) / np.linalg.norm(slope)


@pytest.mark.uncompiled
@pytest.mark.parametrize("power", [2.0, 2.5, 4.0])
def test_first_order_distance_matches_its_definition(power):
    rng = np.random.default_rng(1)
    for _ in range(50):
        point, radii = rng.uniform(0.05, 1, 3) * rng.choice([-1, 1], 3), rng.uniform(0.2, 1, 3)
        expected = slow_radial_distance(point, radii, power)
        assert radial_distance(*point, *radii, power) == pytest.approx(expected, rel=1e-4, abs=1e-6)


def test_frame_is_right_handed_and_leans_to_the_front():
    axes = part_axes((0.3, -1, 0.2), (0, 0, 1))
    assert axes @ axes.T == pytest.approx(np.eye(3))
    assert np.linalg.det(axes) == pytest.approx(1)
    assert axes[1] == pytest.approx(unit((0.3, -1, 0.2)))
    assert axes[2, 2] > 0.9


def test_sweep_of_constant_circles_is_a_capsule():
    start, end, radius = np.array([0.1, 0.2, 0.3]), np.array([0.5, 0.6, -0.1]), 0.1
    body = Body(
        (
            sweep(
                "b", start, end, [(0, radius, radius), (1, radius, radius)], caps=(radius, radius), blend=0.01
            ),
        )
    )
    points = np.random.default_rng(0).uniform(-0.2, 0.8, (5000, 3))
    along = end - start
    at = np.clip((points - start) @ along / (along @ along), 0, 1)
    distance = np.linalg.norm(points - start - at[:, None] * along, axis=1) - radius
    near = np.abs(distance) < 0.02  # further away a part is only said to be far
    assert near.sum() > 20
    assert body(points)[near] == pytest.approx(distance[near], abs=1e-9)


@pytest.mark.uncompiled
def test_profile_shifts_and_widths_place_the_surface():
    part = sweep(
        "b",
        (0, 0, 0),
        (0, 1, 0),
        [(0, 0.1, 0.2, 0.03, 0.04), (1, 0.1, 0.2, 0.03, 0.04)],
        caps=(0.1, 0.1),
        blend=0.01,
    )
    middle = np.array([0, 0.5, 0]) + 0.03 * part.axes[0] + 0.04 * part.axes[2]
    on = np.stack([middle + 0.1 * part.axes[0], middle - 0.1 * part.axes[0], middle + 0.2 * part.axes[2]])
    assert Body((part,))(on) == pytest.approx(0, abs=1e-12)


def test_bounds_contain_the_inside_and_touch_it():
    parts = (
        ellipsoid("b", (0.3, 0, 0), (0.1, 0.3, 0.2), blend=0.02, axis=(1, 1, 0), front=(0, 0.2, 1)),
        sweep(
            "b",
            (0, 0, 0),
            (0.2, 0.5, 0.1),
            [(0, 0.1, 0.05, 0.02), (1, 0.2, 0.1)],
            caps=(0.05, 0.1),
            blend=0.02,
        ),
    )
    for part in parts:
        lower, upper = part.bounds()
        points = np.random.default_rng(0).uniform(lower - 0.2, upper + 0.2, (40_000, 3))
        inside = points[Body((part,)).distances(points)[0] < 0]
        assert (inside >= lower - 1e-9).all()
        assert (inside <= upper + 1e-9).all()
        assert (np.ptp(inside, axis=0) > 0.6 * (upper - lower)).all()


@pytest.mark.uncompiled
def test_joined_parts_swell_at_their_meeting_and_carving_removes():
    a = ellipsoid("b", (0, 0, 0), (0.2, 0.2, 0.2), blend=0.05)
    b = ellipsoid("b", (0.3, 0, 0), (0.2, 0.2, 0.2), blend=0.05)
    hole = ellipsoid("b", (0, 0, 0.2), (0.1, 0.1, 0.1), blend=0.01, carve=True)
    seam = np.array([[0.15, np.sqrt(0.2**2 - 0.15**2), 0]])
    assert Body((a, b))(seam)[0] == pytest.approx(-0.05 / 4)
    assert Body((a,))(np.array([[0, 0, 0.19]]))[0] < 0 < Body((a, hole))(np.array([[0, 0, 0.19]]))[0]


def test_gradient_points_outward_with_unit_length():
    body = Body((ellipsoid("b", (0, 0, 0), (0.2, 0.2, 0.2), blend=0.05),))
    directions = np.random.default_rng(0).normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    assert body.gradient(0.2 * directions) == pytest.approx(directions, abs=1e-5)


@pytest.mark.uncompiled
def test_grid_holds_the_field_at_its_nodes():
    body = Body((ellipsoid("b", (0, 0, 0), (0.2, 0.1, 0.15), blend=0.05),))
    axes = (np.linspace(-0.3, 0.3, 5), np.linspace(-0.2, 0.2, 4), np.linspace(-0.2, 0.3, 3))
    grid = body.on_grid(axes, far=0.05)
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    assert grid.shape == (5, 4, 3)
    assert grid.ravel() == pytest.approx(body(nodes.reshape(-1, 3), far=0.05), abs=1e-6)
    assert grid.max() <= 0.05 + 1e-6

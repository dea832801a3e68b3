import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reports.figures.point_renderer import (
    INSIDE,
    best_azimuth,
    disc_radius,
    fitted_cameras,
    look_from,
    render_points,
)


def plane(n=40, z=0.0):
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    points = np.column_stack([x.ravel(), y.ravel(), np.full(n * n, z)])
    return points, np.tile([0.0, 0.0, 1.0], (n * n, 1))


FRONT = look_from(0, 0)


def test_front_view_of_a_y_up_shape_looks_against_z():
    assert np.allclose(FRONT, np.eye(3))


@given(st.floats(-360, 360), st.floats(-80, 80), st.integers(0, 2))
def test_rotations_are_right_handed_and_keep_up_upwards(azimuth, elevation, up):
    rotation = look_from(azimuth, elevation, up)
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1)
    assert rotation[1, up] > 0
    assert rotation[0, up] == pytest.approx(0, abs=1e-12)


def test_the_widest_side_is_shown():
    points = np.random.default_rng(0).normal(size=(500, 3)) * [5, 1, 0.5]
    seen = points @ look_from(best_azimuth(points), 0).T
    assert np.ptp(seen[:, 0]) > 0.85 * np.ptp(points[:, 0])


def test_projection_follows_the_image_axes():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    camera = fitted_cameras([points], FRONT, 100)[0]
    at = camera.project(points)
    assert at[1, 0] - at[0, 0] == pytest.approx(camera.scale)  # right is to the right
    assert at[0, 1] - at[2, 1] == pytest.approx(camera.scale)  # up is upwards
    assert at[3, 2] - at[0, 2] == pytest.approx(1)  # towards the viewer


def test_clouds_framed_together_share_one_scale():
    small, large = np.random.default_rng(0).random((2, 50, 3)) * np.array([1, 3])[:, None, None]
    a, b = fitted_cameras([small, large], FRONT, 200)
    assert a.scale == b.scale
    assert a.height == b.height == 200
    assert a.width < b.width


def test_a_dense_plane_has_no_gaps_and_the_background_is_transparent():
    points, normals = plane()
    camera = fitted_cameras([points], FRONT, 120, margin=0.25)[0]
    image = render_points(points, normals, np.full((len(points), 3), 0.5), camera)
    assert image.shape == (120, camera.width, 4)
    assert (image[40:80, 40:80, 3] == 255).all()
    assert (image[:5, :, 3] == 0).all()


@pytest.mark.uncompiled
def test_the_nearer_point_hides_the_farther_one():
    points = np.array([[0.0, 0, 0], [0, 0, 1], [-1, -1, 0], [1, 1, 0]])
    colors = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 1]])
    camera = fitted_cameras([points], FRONT, 60)[0]
    normals = np.tile([0.0, 0, 1], (4, 1))
    for order in ([0, 1, 2, 3], [1, 0, 2, 3]):
        image = render_points(points[order], normals[order], colors[order], camera, radius=0.2)
        red, green, blue, alpha = image[30, camera.width // 2]
        assert alpha == 255
        assert green > 200
        assert red == blue == 0


def test_the_inner_side_is_greyed():
    points, normals = plane()
    camera = fitted_cameras([points], FRONT, 60)[0]
    colors = np.tile([1.0, 0, 0], (len(points), 1))
    outside = render_points(points, normals, colors, camera)[30, 30, :3] / 255
    inside = render_points(points, -normals, colors, camera)[30, 30, :3] / 255
    assert outside[1] == outside[2] == 0
    assert np.ptp(inside) < 0.4 * np.ptp(outside)
    assert inside[2] > 0.5 * INSIDE[2]


def reference_depth(seen, facing, size, height, width):
    """Pixel by pixel, disc by disc."""
    depth = np.full((height, width), -np.inf)
    for row in range(height):
        for col in range(width):
            for (x, y, z), (nx, ny, nz) in zip(seen, facing, strict=True):
                dx, dy = col + 0.5 - x, row + 0.5 - y
                steep = max(abs(nz), 0.2) * (1 if nz >= 0 else -1)
                dz = -(nx * dx - ny * dy) / steep
                if dx * dx + dy * dy + dz * dz <= size * size:
                    depth[row, col] = max(depth[row, col], z + dz)
    return depth


@pytest.mark.uncompiled
@given(st.integers(0, 10_000))
@settings(max_examples=15, deadline=None)
def test_splats_equal_a_slow_renderer(seed):
    from reports.figures.point_renderer import _splat

    rng = np.random.default_rng(seed)
    seen = rng.uniform(-3, 15, size=(6, 3))
    facing = rng.normal(size=(6, 3))
    facing /= np.linalg.norm(facing, axis=1, keepdims=True)
    depth, winner = _splat(seen, facing, 3.0, 12, 10)
    assert np.allclose(depth, reference_depth(seen, facing, 3.0, 12, 10))
    assert ((winner >= 0) == np.isfinite(depth)).all()


def test_the_same_cloud_gives_the_same_picture():
    rng = np.random.default_rng(3)
    points, normals, colors = rng.normal(size=(3, 300, 3))
    camera = fitted_cameras([points], FRONT, 80)[0]
    first, second = (render_points(points, normals, np.abs(colors) % 1, camera) for _ in range(2))
    assert np.array_equal(first, second)


@pytest.mark.parametrize("n", [1, 2, 5])
def test_tiny_clouds_are_drawn(n):
    points = np.random.default_rng(n).random((n, 3))
    camera = fitted_cameras([points], FRONT, 40)[0]
    assert disc_radius(points) > 0
    image = render_points(points, np.tile([0.0, 0, 1], (n, 1)), np.ones((n, 3)), camera)
    assert image[..., 3].max() == 255

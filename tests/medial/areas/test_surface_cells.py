import numpy as np
import pytest

from medial import density_weights, surface_areas
from tests.medial import clouds


def test_sphere():
    points, normals = clouds.sphere(2000, radius=3.0)
    areas = surface_areas(points, normals)
    assert areas.sum() == pytest.approx(4 * np.pi * 9, rel=0.005)
    assert areas == pytest.approx(np.full(2000, areas.mean()), rel=0.1)


@pytest.mark.uncompiled
def test_cells_of_a_square_grid_are_its_squares():
    x, y = np.meshgrid(np.arange(20.0), np.arange(20.0))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(400)])
    normals = np.tile([0, 0, 1.0], (400, 1))
    areas = surface_areas(points, normals).reshape(20, 20)
    assert areas[3:-3, 3:-3] == pytest.approx(np.ones((14, 14)))
    assert areas.max() < 3  # at the corners, which nothing bounds


def test_cells_tile_a_plane_whatever_the_sampling():
    """Cells well inside a square sum to the area they cover, dense on the left and sparse on the right."""
    random = np.random.default_rng(0)
    u, v = np.meshgrid(np.arange(60.0), np.arange(40.0))
    u, v = (
        (u.ravel() + random.uniform(0.2, 0.8, 2400)) / 60,
        (v.ravel() + random.uniform(0.2, 0.8, 2400)) / 40,
    )
    points = np.column_stack([u**1.5, v, np.zeros(2400)])
    areas = surface_areas(points, np.tile([0, 0, 1.0], (2400, 1)))
    inner = (np.abs(points[:, :2] - 0.5) < 0.4).all(axis=1)
    assert areas[inner].sum() == pytest.approx(0.64, rel=0.03)


def test_the_other_sheet_does_not_count():
    points, normals = clouds.planes(1200, gap=1e-3)
    assert surface_areas(points, normals).sum() == pytest.approx(2, rel=0.08)


def test_a_stray_point_stands_for_little():
    points, normals = clouds.sphere(500)
    points = np.concatenate([points, [[9.0, 0, 0]]])
    normals = np.concatenate([normals, [[1.0, 0, 0]]])
    areas = surface_areas(points, normals)
    assert areas[-1] < 20 * np.median(areas)


def test_invariant_to_motion_and_order():
    points, normals = clouds.body(600)
    areas = surface_areas(points, normals)
    turn, order = clouds.rotation(2), np.random.default_rng(0).permutation(600)
    moved = surface_areas(2 * points[order] @ turn.T + 5, normals[order] @ turn.T)
    assert moved == pytest.approx(4 * areas[order], rel=1e-6)


def test_density_weights_sum_to_the_reference():
    areas = np.random.default_rng(0).uniform(1, 3, 100)
    assert density_weights(areas, 5000).sum() == pytest.approx(5000)

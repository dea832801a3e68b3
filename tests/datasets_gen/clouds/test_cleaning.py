import numpy as np
import pytest

from datasets_gen import InputError
from datasets_gen.clouds.cleaning import with_sound_normals, without_gaps
from datasets_gen.clouds.point_cloud import PointCloud
from datasets_gen.points.fibonacci import fibonacci_sphere
from datasets_gen.points.missing_normals import filled_normals

BALL = fibonacci_sphere(400)


def test_points_that_are_no_numbers_are_dropped_with_a_count():
    points = BALL.copy()
    points[3, 1], points[7], points[9, 0] = np.nan, np.nan, np.inf
    found = without_gaps(PointCloud(points, BALL), "'a.pcd'")
    kept = np.setdiff1d(np.arange(400), [3, 7, 9])
    assert np.array_equal(found.points, BALL[kept])
    assert np.array_equal(found.normals, BALL[kept])
    assert found.remarks == ("3 points of 400 NaN or infinite, the first is number 3: dropped",)
    with pytest.raises(InputError, match=r"'a\.pcd' has no points: all 400 are NaN or infinite"):
        without_gaps(PointCloud(np.full((400, 3), np.nan)), "'a.pcd'")


@pytest.mark.parametrize("side", [1, -1], ids=["outward", "inward"])
def test_a_few_normals_that_are_lacking_are_those_of_the_surface_on_the_side_of_the_others(side):
    """On a sphere the normal is the place."""
    normals = side * BALL
    lacking = np.zeros(400, dtype=bool)
    lacking[[0, 50, 51, 52, 399]] = True
    normals = np.where(lacking[:, None], [[0.0, 0, 0]], normals)
    normals[51] = np.nan
    found = with_sound_normals(PointCloud(BALL, normals))
    assert found.remarks == ("5 normals of 400 zero or NaN: estimated from their neighbours",)
    assert (np.einsum("nd,nd->n", found.normals, side * BALL) > 0.99).all()
    assert np.array_equal(found.normals[~lacking], side * BALL[~lacking])


def test_many_that_are_lacking_leave_none():
    normals = np.where(np.arange(400)[:, None] < 41, np.nan, BALL)
    found = with_sound_normals(PointCloud(BALL, normals))
    assert found.normals is None
    assert found.remarks == ("41 normals of 400 zero or NaN, more than 10 %: none of the given ones is used",)
    assert with_sound_normals(PointCloud(BALL, 0 * BALL)).remarks == ()
    assert with_sound_normals(PointCloud(BALL, BALL)).normals is not None


def test_where_points_span_no_plane_the_neighbours_normals_are_taken():
    points = np.zeros((30, 3))
    points[:, 0] = np.arange(30) // 10  # ten copies of three places on a line
    normals = np.tile([0.0, 1.0, 0.0], (30, 1))
    lacking = np.arange(30) == 4
    normals[4] = 0
    assert np.allclose(filled_normals(points, normals, lacking)[4], [0, 1, 0])

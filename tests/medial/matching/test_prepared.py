"""What is prepared for a pair of clouds."""

import numpy as np
import pytest

from datasets_gen.points.farthest import farthest_from_mean
from medial.matching.common_units import MOST_POINTS
from medial.matching.prepared import ORDERED, cover_of
from medial.matching.registration.direction import BALLS
from medial.matching.registration.refinement import LOOK_BACK


@pytest.mark.parametrize("count", [5, ORDERED, ORDERED + 700])
def test_cover_of_a_cloud_that_is_taken_as_a_whole(count):
    points = np.random.default_rng(count).standard_normal((count, 3))
    cover = cover_of(points)
    assert np.array_equal(np.sort(cover), np.arange(count))
    assert np.array_equal(cover[:ORDERED], farthest_from_mean(points, min(count, ORDERED)))


def test_cover_does_not_depend_on_the_order_of_the_points():
    random = np.random.default_rng(0)
    points = random.standard_normal((ORDERED + 500, 3))
    shuffled = random.permutation(len(points))
    assert np.array_equal(shuffled[cover_of(points[shuffled])], cover_of(points))


def test_cover_of_a_large_cloud_is_in_farthest_point_order():
    points = np.random.default_rng(0).standard_normal((MOST_POINTS + 500, 3))
    assert np.array_equal(cover_of(points), farthest_from_mean(points, MOST_POINTS))


def test_what_stands_for_a_cloud_is_ordered():
    assert max(BALLS, LOOK_BACK) <= ORDERED <= MOST_POINTS

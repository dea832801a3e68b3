"""Patches of one side, and the seams between them."""

import numpy as np
import pytest

from medial.sides import Neighbours
from tests.medial import clouds


def capped(height, count=1000):
    """A sphere with normals inward below a height, and which points those are."""
    points, normals = clouds.sphere(count)
    below = points[:, 2] < height
    return points, np.where(below[:, None], -normals, normals), below


def test_disagreement():
    points, normals = clouds.sphere(400)
    near = Neighbours.of(points)
    assert near.disagreement(normals) == 0
    signs = np.where(np.arange(400) % 2, 1.0, -1.0)[:, None]
    assert near.disagreement(signs * normals) > 0.3


def test_a_seam_is_where_the_sides_meet():
    points, normals, _ = capped(-0.4)
    near = Neighbours.of(points)
    seam = near.rows[near.at_seams(normals)]
    assert len(seam) > 50
    assert np.abs(points[seam, 2] + 0.4).max() < 0.15
    assert len(near.patches(normals)) == 2


@pytest.mark.parametrize("gap", [0.2, 0.05, 0.02])
def test_faces_of_a_plate_meet_in_no_seam(gap):
    points, normals = clouds.planes(2000, gap)  # 0.03 apart on either face
    assert not Neighbours.of(points).at_seams(normals).any()


def test_patches_agree_with_the_largest():
    points, normals, below = capped(-0.4)
    near = Neighbours.of(points)
    assert np.array_equal(near.without_seams(normals, near.patches(normals)), below)


def test_stripes_are_turned_in_turn():
    points, right = clouds.cylinder(3000)
    inward = (np.floor(points[:, 2] / 0.5) % 2) == 1
    near = Neighbours.of(points)
    normals = np.where(inward[:, None], -right, right)
    turned = near.without_seams(normals, near.patches(normals))
    assert np.array_equal(turned, inward) or np.array_equal(turned, ~inward)


def test_two_clouds_that_do_not_touch_are_left_alone():
    points, normals = clouds.sphere(300)
    both = np.concatenate([points, points + np.array([10, 0, 0])])
    near = Neighbours.of(both)
    signed = np.concatenate([normals, -normals])
    assert not near.without_seams(signed, near.patches(signed)).any()

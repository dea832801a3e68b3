"""The bounds over two leaves never lose a pair whose ball may pass."""

import numpy as np
import pytest

from medial.similarity.candidate_ball import candidate_ball, smallest_width
from medial.similarity.candidate_pairs import _joined, make_screen
from medial.similarity.critical_radius import critical_grid
from medial.similarity.leaves import LEAF, kd_cloud
from tests.medial import clouds

SHAPES = {
    "sphere": clouds.sphere(400),
    "cylinder": clouds.cylinder(400),
    "planes": clouds.planes(400),
    "body": clouds.body(700),
    "random": clouds.random_cloud(400),
    "far from the origin": (clouds.body(400)[0] + 1e4, clouds.body(400)[1]),
}


def passing_leaves(cloud, tangency, cap):
    """Pairs of leaves that some ball tangent enough and small enough touches, by looking at all of them."""
    position, normal = (cloud.x, cloud.y, cloud.z), (cloud.u, cloud.v, cloud.w)
    count = len(cloud.spheres)
    found = np.zeros((count, count), dtype=bool)
    for i in range(len(cloud.x)):
        for j in range(i + 1, len(cloud.x)):
            *_, radius, f = candidate_ball.py_func(*position, *normal, i, j)
            found[i // LEAF, j // LEAF] |= 0 < radius <= cap and f >= tangency
    return found


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("share", [1.0, 0.6])
def test_leaves_that_a_ball_can_join_are_kept(name, share):
    points, normals = SHAPES[name]
    cloud, _ = kd_cloud(points, normals, np.ones(len(points)))
    tangency, cap = 0.3, share * smallest_width(points)
    screen = make_screen(cloud, critical_grid(cloud, 20.0, tangency, cap), tangency, cap)
    count = len(cloud.spheres)
    kept = np.zeros((count, count), dtype=bool)
    for a in range(count):
        _joined(screen.leaves, a, a, screen.least, screen.largest, kept[a, a:])
    passing = passing_leaves(cloud, tangency, cap)
    assert passing.any()
    assert not (passing & ~kept).any()


def test_leaves_of_one_flat_sheet_are_dropped():
    points, normals = clouds.planes(2000)
    cloud, _ = kd_cloud(points, normals, np.ones(len(points)))
    cap = smallest_width(points)
    screen = make_screen(cloud, critical_grid(cloud, 20.0, 0.3, cap), 0.3, cap)
    kept = np.zeros(len(cloud.spheres), dtype=bool)
    _joined(screen.leaves, 0, 0, screen.least, screen.largest, kept)
    gap = np.linalg.norm(cloud.spheres[:, :3] - cloud.spheres[0, :3], axis=1)
    flat = cloud.cones[:, 3] > 0.99
    beside = flat & (cloud.cones[:, :3] @ cloud.cones[0, :3] > 0.99) & (gap > 4 * cloud.spheres[:, 3])
    assert flat[0]
    assert beside.sum() > 50
    assert not kept[beside].any()
    assert kept[flat & ~beside & (gap < 1.2 * cap)].any()

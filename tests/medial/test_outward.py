import numpy as np
import pytest

from medial.outward import check_normals, disagreement, estimate_normals, inside_share
from tests.medial import clouds


@pytest.mark.parametrize("shape", ["sphere", "torus", "cylinder", "body"])
def test_estimated_normals_point_outward(shape):
    points, normals = getattr(clouds, shape)(1200)
    found = estimate_normals(points)
    assert np.linalg.norm(found, axis=1) == pytest.approx(np.ones(1200))
    assert (np.einsum("ij,ij->i", found, normals) > 0.7).mean() > 0.97


def test_separate_parts_are_oriented_each():
    points, normals = clouds.sphere(500)
    both = np.concatenate([points, 0.5 * points + [20, 0, 0]])
    found = estimate_normals(both)
    assert np.einsum("ij,ij->i", found, np.concatenate([normals, normals])).min() > 0.9


def test_share_of_balls_inside():
    points, normals = clouds.body(1000)
    assert inside_share(points, normals) > 0.75
    assert inside_share(points, -normals) < 0.25
    flat = points * [1, 1, 0]
    assert inside_share(flat, np.tile([0, 0, 1.0], (1000, 1))) == 1


def test_share_is_decided_on_incomplete_clouds():
    points, normals = clouds.body(1000, holes=10)
    assert inside_share(points, normals) > 0.7


def test_disagreement():
    points, normals = clouds.sphere(400)
    assert disagreement(points, normals) == 0
    signs = np.where(np.arange(400) % 2, 1.0, -1.0)[:, None]
    assert disagreement(points, signs * normals) > 0.3


def test_check_keeps_or_flips(caplog):
    points, normals = clouds.torus(800)
    assert check_normals(points, normals) is normals
    assert caplog.text == ""
    assert (check_normals(points, -normals) == normals).all()
    assert "flipped" in caplog.text

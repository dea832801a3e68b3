"""Normals that are missing, inward, on a part inward, or no normals at all."""

import numpy as np
import pytest

import medialbench as mb
from medial.outward import check_normals, disagreement, estimate_normals, misfit, outward_share
from tests.medial import clouds


def right(found, normals):
    """Share of normals on the right side."""
    return float((np.einsum("ij,ij->i", found, normals) > 0).mean())


@pytest.fixture(scope="module")
def partial():
    """A body seen from the front alone, 60 % missing: the old test called its normals inward."""
    body = mb.load("human")
    return mb.scan(body["sit"], threshold=0.5, views="left:2", points=3000)


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


def test_estimated_normals_of_a_scan_with_holes():
    """The spanning tree and the pieces' centroids alone had 47 % right."""
    scan = mb.scan(mb.load("human")["walk"], threshold=0.9, views=6, points=6000, seed=4)
    assert right(estimate_normals(scan.points), scan.normals) > 0.9


def test_stray_points_do_not_turn_the_others():
    points, _ = clouds.body(1000)
    with_strays = np.concatenate([points, [[1e6, 0, 0], [0, 1e4, 0]]])
    found = estimate_normals(with_strays)
    assert np.array_equal(found[:1000], estimate_normals(points))
    assert np.isfinite(found).all()


def test_outward_share_tells_the_side(partial):
    for points, normals in (
        clouds.body(1000),
        clouds.body(1000, holes=10),
        (partial.points, partial.normals),
    ):
        assert outward_share(points, normals) > 0.95
        assert outward_share(points, -normals) < 0.05
    flat = clouds.body(1000)[0] * [1, 1, 0]
    assert outward_share(flat, np.tile([0, 0, 1.0], (1000, 1))) == 0.5


def test_disagreement():
    points, normals = clouds.sphere(400)
    assert disagreement(points, normals) == 0
    signs = np.where(np.arange(400) % 2, 1.0, -1.0)[:, None]
    assert disagreement(points, signs * normals) > 0.3


def test_check_keeps_or_flips(partial, caplog):
    for points, normals in (clouds.torus(800), (partial.points, partial.normals)):
        caplog.clear()
        assert check_normals(points, normals) is normals
        assert caplog.text == ""
        assert (check_normals(points, -normals) == normals).all()
        assert f"{len(points)} of {len(points)} normals point inward: flipped" in caplog.text


def test_each_part_has_its_own_side(caplog):
    points, normals = clouds.sphere(600)
    both = np.concatenate([points, 0.5 * points + [20, 0, 0]])
    found = check_normals(both, np.concatenate([normals, -normals]))
    assert np.array_equal(found, np.concatenate([normals, normals]))
    assert "600 of 1200 normals point inward: flipped" in caplog.text


@pytest.mark.parametrize("axis", [0, 2])
def test_half_a_scan_inward(partial, axis, caplog):
    points, normals = partial.points, partial.normals
    half = np.where(points[:, axis] < np.median(points[:, axis]), -1.0, 1.0)[:, None]
    assert right(check_normals(points, half * normals), normals) > 0.85
    assert "point inward: flipped" in caplog.text


def test_random_sides(partial, caplog):
    signs = np.random.default_rng(0).choice([-1.0, 1.0], len(partial))[:, None]
    assert right(check_normals(partial.points, signs * partial.normals), partial.normals) > 0.85
    assert "point inward: flipped" in caplog.text


@pytest.mark.parametrize(("axes", "said"), [([0, 2, 1], "order x z y"), ([1, 2, 0], "order z x y")])
def test_swapped_axes_are_seen(partial, axes, said, caplog):
    assert said in misfit(partial.points, partial.normals[:, axes])
    found = check_normals(partial.points, partial.normals[:, axes])
    assert np.array_equal(found, estimate_normals(partial.points))
    assert "do not belong to the points" in caplog.text


def test_colours_are_no_normals(partial, caplog):
    colours = np.random.default_rng(1).uniform(size=partial.points.shape)
    colours /= np.linalg.norm(colours, axis=1, keepdims=True)
    found = check_normals(partial.points, colours)
    assert np.array_equal(found, estimate_normals(partial.points))
    assert "estimated anew" in caplog.text


def test_noisy_normals_and_points_are_left_alone(partial, caplog):
    random = np.random.default_rng(2)
    points = partial.points + random.normal(scale=0.3 * 0.01, size=partial.points.shape)
    normals = partial.normals + random.normal(scale=0.2, size=partial.points.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert check_normals(points, normals) is normals
    assert caplog.text == ""

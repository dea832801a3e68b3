from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from datasets_gen import InputError
from evaluation.metrics.correspondence import (
    CURVE,
    SurfacePoints,
    area_under_curve,
    correspondence_error,
    intersection_over_union,
    least_errors,
    overlap,
    pck_curve,
    sure_and_right,
    symmetric_mean,
    with_unmatched,
)
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.metrics.mirror_images import closest_barycentrics, mirror_points
from tests.evaluation.meshes import as_shape, plane, random_points, sphere

BALL = sphere(3)


@cache
def on_ball():
    """Distances on the ball."""
    return SurfaceDistance(BALL)


def points(n, seed=0):
    return SurfacePoints(*random_points(BALL, n, seed))


def test_identity_has_no_error_and_unmatched_points_no_value():
    cloud = points(30)
    image = np.arange(30)
    image[3] = -1
    errors = correspondence_error(on_ball(), cloud, cloud, image, BALL.area)
    assert np.isnan(errors[3])
    assert np.allclose(np.delete(errors, 3), 0)


def test_error_of_the_antipodes_on_a_unit_sphere():
    # half a great circle over sqrt(4 pi): pi / sqrt(4 pi) = 0.886
    top = SurfacePoints(np.array([0]), np.array([[1.0, 0, 0]]))
    opposite = np.linalg.norm(BALL.vertices + BALL.vertices[BALL.faces[0, 0]], axis=1).argmin()
    face, corner = np.argwhere(BALL.faces == opposite)[0]
    bottom = SurfacePoints(np.array([face]), np.eye(3)[[corner]])
    error = correspondence_error(on_ball(), top, bottom, np.array([0]), BALL.area)
    assert error[0] == pytest.approx(np.pi / np.sqrt(4 * np.pi), rel=0.01)


@pytest.mark.parametrize("image", [np.zeros(4, int), np.full(5, 5), np.full(5, -2)])
def test_a_map_must_fit_its_clouds(image):
    with pytest.raises(InputError, match="map"):
        correspondence_error(on_ball(), points(5), points(5), image, BALL.area)


def test_errors_do_not_depend_on_the_unit_of_length():
    from dataclasses import replace

    large = replace(BALL, vertices=1000 * BALL.vertices)
    image = np.random.default_rng(0).integers(20, size=20)
    one = correspondence_error(on_ball(), points(20), points(20, 1), image, BALL.area)
    other = correspondence_error(SurfaceDistance(large), points(20), points(20, 1), image, large.area)
    assert np.allclose(one, other, rtol=1e-9)


@given(st.integers(0, 10**6), st.integers(1, 40))
@settings(max_examples=30, deadline=None)
def test_no_map_has_a_lower_error_than_the_least_at_any_point(seed, count):
    source, target = points(25, [seed, 0]), points(count, [seed, 1])
    least = least_errors(on_ball(), source, target, BALL.area)
    image = np.random.default_rng(seed).integers(count, size=25)
    assert (correspondence_error(on_ball(), source, target, image, BALL.area) >= least - 1e-12).all()
    every = [correspondence_error(on_ball(), source, target, np.full(25, j), BALL.area) for j in range(count)]
    assert np.allclose(np.min(every, axis=0), least, atol=1e-12)


def test_share_of_sure_points_that_are_right():
    confidence = np.array([0.95, 0.95, 0.95, 0.5, 0.99])
    assert sure_and_right(np.array([0.05, 0.2, 0.09, 0.0, np.nan]), confidence) == pytest.approx(2 / 3)
    assert sure_and_right(np.zeros(5), np.full(5, 0.9)) is None


@given(arrays(np.float64, st.integers(1, 50), elements=st.floats(0, 1)))
def test_curve_against_counting(errors):
    curve = pck_curve(errors)
    assert np.allclose(curve, [(errors <= at).mean() for at in CURVE])
    assert (np.diff(curve) >= 0).all()
    assert 0 <= area_under_curve(curve) <= 1


def test_curve_counts_unmatched_points_as_wrong():
    assert pck_curve(np.array([0.0, np.nan]))[-1] == 0.5
    assert area_under_curve(pck_curve(np.zeros(4))) == 1


def test_one_choice_per_map_between_truth_and_mirror_image():
    assert symmetric_mean(3.0, 1.0) == (1.0, True)
    assert symmetric_mean(1.0, 3.0) == (1.0, False)


def test_overlap_and_intersection_over_union():
    line = np.column_stack([np.arange(10.0), np.zeros(10), np.zeros(10)])
    assert overlap(line, line[:4], 1.0).tolist() == [True] * 5 + [False] * 5
    some, other = np.array([1, 1, 0, 0], bool), np.array([1, 0, 1, 0], bool)
    assert intersection_over_union(some, other) == pytest.approx(1 / 3)
    assert intersection_over_union(some & ~some, some & ~some) == 1


def test_mirror_images_on_a_symmetric_mesh():
    reflected = BALL.vertices * [-1, 1, 1]
    mirror = np.array([np.linalg.norm(BALL.vertices - p, axis=1).argmin() for p in reflected])
    assert np.allclose(BALL.vertices[mirror], reflected)
    cloud = points(200)
    image = mirror_points(BALL, mirror, cloud)
    assert np.allclose(image.on(BALL), cloud.on(BALL) * [-1, 1, 1], atol=1e-9)
    assert np.allclose(mirror_points(BALL, mirror, image).on(BALL), cloud.on(BALL), atol=1e-9)


def test_faces_without_area_are_no_mirror_image():
    flat = np.array([[[0.0, 0, 0], [1, 0, 0], [1, 0, 0]]])
    assert np.isnan(closest_barycentrics(flat, np.array([[0.3, 1.0, 0]]))).all()
    pole = np.vstack([BALL.faces, [[0, 1, 1]]]).astype(np.int32)
    shape, mirror = as_shape(BALL.vertices, pole), np.arange(len(BALL.vertices))
    assert np.allclose(mirror_points(shape, mirror, points(200)).on(shape), points(200).on(BALL), atol=1e-9)


def test_closest_point_of_a_triangle_against_sampling():
    rng = np.random.default_rng(0)
    triangles, where = rng.normal(size=(50, 3, 3)), rng.normal(size=(50, 3)) * 2
    weights = closest_barycentrics(triangles, where)
    assert np.allclose(weights.sum(1), 1)
    assert (weights >= -1e-12).all()
    found = np.linalg.norm(np.einsum("nc,ncd->nd", weights, triangles) - where, axis=1)
    samples = rng.dirichlet([0.5] * 3, 20_000)
    best = np.array(
        [np.linalg.norm(samples @ t - p, axis=1).min() for t, p in zip(triangles, where, strict=True)]
    )
    assert (found <= best + 1e-9).all()
    assert np.allclose(found, best, atol=0.05)


class FlatDistance:
    """Distances on a flat, convex sheet: straight lines."""

    def __init__(self, shape):
        self._shape = shape

    def __call__(self, face_ids, barycentrics, other_face_ids, other_barycentrics):
        here, there = (
            self._shape.at(*each) for each in ((face_ids, barycentrics), (other_face_ids, other_barycentrics))
        )
        return np.linalg.norm(here - there, axis=1)

    def to_nearest(self, face_ids, barycentrics, other_face_ids, other_barycentrics):
        here = self._shape.at(face_ids, barycentrics)
        there = self._shape.at(other_face_ids, other_barycentrics)
        return np.linalg.norm(here[:, None] - there, axis=2).min(axis=1)


SHEET = plane(4)


def on_sheet(n, seed):
    return SurfacePoints(*random_points(SHEET, n, seed))


def test_flat_errors_by_loops():
    """From where a point is mapped to where it belongs, over the root of the area, here 9."""
    source, target, area = on_sheet(6, 0), on_sheet(4, 1), 9.0
    image = np.array([2, -1, 0, 3, 0, 3])
    here, there = (
        [
            sum(w * SHEET.vertices[v] for w, v in zip(weights, SHEET.faces[face], strict=True))
            for face, weights in zip(points.face_ids, points.barycentrics, strict=True)
        ]
        for points in (source, target)
    )
    found = correspondence_error(FlatDistance(SHEET), source, target, image, area)
    least = least_errors(FlatDistance(SHEET), source, target, area)
    for i, j in enumerate(image):
        right = np.sqrt(sum((here[i] - there[j]) ** 2)) / 3
        assert np.isnan(found[i]) if j == -1 else found[i] == pytest.approx(right)
        assert least[i] == pytest.approx(min(np.sqrt(sum((here[i] - q) ** 2)) for q in there) / 3)


@pytest.mark.parametrize("lowest", [-2, -1, 0])
@pytest.mark.parametrize("highest", [3, 4])
def test_flat_maps_hold_ids_of_the_target_or_none(lowest, highest):
    source, target = on_sheet(3, 0), on_sheet(4, 1)
    image = np.array([lowest, 1, highest])
    if lowest == -2 or highest == 4:
        with pytest.raises(InputError, match=rf"from {lowest} to {highest}; they must lie in \[0, 4\)"):
            correspondence_error(FlatDistance(SHEET), source, target, image, 1.0)
    else:
        found = correspondence_error(FlatDistance(SHEET), source, target, image, 1.0)
        assert np.isnan(found).tolist() == [lowest == -1, False, False]
    found = correspondence_error(FlatDistance(SHEET), source, target, np.full(3, 2), 1.0)
    assert np.isfinite(found).all()  # all to one place
    for wrong in (image[:2], np.zeros(4, int)):
        with pytest.raises(InputError, match="does not fit a source of 3"):
            correspondence_error(FlatDistance(SHEET), source, target, wrong, 1.0)


def test_flat_clouds_without_points_have_no_errors():
    none = on_sheet(0, 0)
    assert correspondence_error(FlatDistance(SHEET), none, on_sheet(2, 0), np.zeros(0, int), 1.0).shape == (
        0,
    )


def test_points_without_a_match_cost_a_random_one_but_no_less_than_the_best():
    errors, random, least = [0.3, np.nan, np.nan], [0.9, 0.5, 0.5], [0.1, 0.2, 0.7]
    assert with_unmatched(*map(np.array, (errors, random, least))).tolist() == [0.3, 0.5, 0.7]


def test_sure_is_above_nine_tenths_and_right_below_one():
    """Both limits themselves do not count."""
    confidence = np.array([0.9, 0.91, 0.91, 0.91, 0.91, 0.1])
    assert sure_and_right(np.array([0.0, 0.1, 0.099, 5.0, 0.0, 0.0]), confidence) == 0.5
    assert sure_and_right(np.array([0.0, np.nan, np.nan, np.nan, np.nan, 0.0]), confidence) is None
    assert sure_and_right(np.array([np.nan, np.nan, 0.5]), np.array([0.95, 0.2, 0.95])) == 0


def test_curve_of_three_points_by_hand():
    errors, at = np.array([0.2, 0.1, np.nan, 0.1]), np.array([0.0, 0.1, 0.15, 0.2, 0.4])
    curve = pck_curve(errors, at)
    assert curve.tolist() == [0, 0.5, 0.5, 0.75, 0.75]
    area = 0.1 * 0.25 + 0.05 * 0.5 + 0.05 * 0.625 + 0.2 * 0.75
    assert area_under_curve(curve, at) == pytest.approx(area / 0.4)
    assert area_under_curve(curve[1:], at[1:]) == pytest.approx((area - 0.025) / 0.3)
    assert (CURVE[0], CURVE[-1], len(CURVE)) == (0, 0.25, 51)
    assert pck_curve(np.empty(0), at).tolist() == [0] * 5
    assert pck_curve(np.array([0.1]), at).tolist() == [0, 1, 1, 1, 1]


def test_of_equal_means_the_truth_is_taken():
    assert symmetric_mean(2.0, 2.0) == (2.0, False)


def test_overlap_and_union_by_hand():
    place = np.array([[0.0, 0, 0], [3, 4, 0], [0, 0, 6]])
    assert overlap(place, place[:1], 5.0).tolist() == [True, True, False]
    some = np.array([True, True, True, False, False, False])
    other = np.array([False, True, True, True, True, False])
    assert intersection_over_union(some, other) == pytest.approx(2 / 5)
    assert intersection_over_union(some, ~some) == 0


def test_points_are_chosen_by_index_and_mask():
    cloud = on_sheet(5, 0)
    assert len(cloud) == 5
    assert np.array_equal(cloud[np.array([3, 1])].on(SHEET), cloud.on(SHEET)[[3, 1]])
    assert len(cloud[np.arange(5) > 1]) == 3

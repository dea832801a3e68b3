"""Scores of maps on a sphere, where geodesic distances are angles, and on two pieces."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from datasets_gen import InputError, Shape, load
from datasets_gen.correspondences.point_map import PointMap
from evaluation.metrics.map_score import score_map, score_scans, truth_of_pair
from scanner_sim import sample


def as_target(mesh: trimesh.Trimesh) -> Shape:
    return Shape(np.array(mesh.vertices), np.array(mesh.faces, np.int32), "target", "target", "target")


SPHERE = as_target(trimesh.creation.icosphere(4))
ALL = np.arange(len(SPHERE.vertices))
IDENTITY = PointMap(ALL)


def test_the_right_map_has_no_error():
    found = score_map(IDENTITY, IDENTITY, SPHERE)
    assert np.abs(found.errors).max() < 1e-9
    assert found.summary()["PCK@1 %"] == 100
    assert found.summary()["AUC"] == pytest.approx(100)


def test_errors_are_angles_over_the_root_of_the_area():
    rng = np.random.default_rng(0)
    image = rng.permutation(ALL)
    found = score_map(PointMap(image), IDENTITY, SPHERE)
    cosines = np.clip(np.einsum("nd,nd->n", SPHERE.vertices[image], SPHERE.vertices), -1, 1)
    assert np.allclose(found.errors, np.arccos(cosines) / np.sqrt(4 * np.pi), rtol=0.01, atol=1e-3)
    assert found.summary()["mean"] == pytest.approx(100 * (np.pi / 2) / np.sqrt(4 * np.pi), rel=0.02)


def test_triangles_with_weights_are_places_between_vertices():
    """The middle of a triangle is as far from each corner as theory says; the corner itself is right."""
    corners = SPHERE.faces[:, 0]
    truth = PointMap(corners.astype(np.int64))
    faces = np.arange(len(corners))
    right = score_map(PointMap(faces, np.eye(3)[np.zeros(len(faces), int)]), truth, SPHERE)
    assert np.abs(right.errors).max() < 1e-9
    middle = score_map(PointMap(faces, np.full((len(faces), 3), 1 / 3)), truth, SPHERE)
    triangle = SPHERE.vertices[SPHERE.faces]
    straight = np.linalg.norm(triangle.mean(axis=1) - triangle[:, 0], axis=1) / np.sqrt(SPHERE.area)
    assert np.allclose(middle.errors, straight, rtol=1e-6)


def test_a_point_without_a_match_counts_like_a_random_one():
    """On a sphere the mean distance from any point is a quarter of the circumference."""
    found = score_map(PointMap(np.full(len(ALL), -1)), IDENTITY, SPHERE)
    assert found.matched == 0
    assert np.allclose(found.counted, (np.pi / 2) / np.sqrt(4 * np.pi), rtol=0.05)
    assert found.summary()["PCK@20 %"] == 0


def test_points_whose_right_place_is_unknown_are_left_out():
    truth = PointMap(np.where(ALL % 2, ALL, -1))
    found = score_map(PointMap(np.where(ALL % 2, ALL, 0)), truth, SPHERE)
    assert len(found.errors) == (ALL % 2).sum()
    assert found.counted.max() < 1e-9


def test_the_mirror_image_of_the_truth_is_chosen_for_the_whole_map():
    mirror = trimesh.proximity.ProximityQuery(trimesh.Trimesh(SPHERE.vertices, SPHERE.faces, process=False))
    image = mirror.vertex(SPHERE.vertices * [-1, 1, 1])[1]
    found = score_map(PointMap(image), IDENTITY, SPHERE, PointMap(image))
    assert (found.symmetric, found.flipped) == (pytest.approx(0, abs=1e-9), True)
    assert found.counted.mean() > 0.1
    with pytest.raises(InputError, match="mirrored ground truth lacks points"):
        score_map(PointMap(image), IDENTITY, SPHERE, PointMap(np.full(len(ALL), -1)))


def test_a_match_on_another_piece_is_counted_as_none():
    two = trimesh.util.concatenate(
        [trimesh.creation.icosphere(2), trimesh.creation.icosphere(2).apply_translation([5, 0, 0])]
    )
    half = 162
    target = as_target(two)
    image = np.arange(2 * half)
    image[:10] += half
    found = score_map(PointMap(image), PointMap(np.arange(2 * half)), target)
    assert found.elsewhere == 10
    assert found.matched == pytest.approx(1 - 10 / (2 * half))
    assert np.isfinite(found.counted).all()


def test_a_template_gives_the_truth_of_a_pair():
    """Template points 0, 1, 2 lie on vertices 4, 0, 4 of the source and 7, 8, 9 of the target."""
    found = truth_of_pair(PointMap(np.array([4, 0, 4, -1])), PointMap(np.array([7, 8, 9, 1])), 6)
    assert found.ids.tolist() == [8, -1, -1, -1, 7, -1]
    with pytest.raises(InputError, match="4 template points on the source, 1 on the target"):
        truth_of_pair(PointMap(np.array([4, 0, 4, -1])), PointMap(np.array([7])), 6)
    with pytest.raises(InputError, match="names number 4 of a target of 3 points"):
        truth_of_pair(PointMap(np.array([4])), PointMap(np.array([7])), 3)


@pytest.mark.parametrize(
    ("found", "truth", "said"),
    [
        (PointMap(np.array([0])), IDENTITY, "the map has 1 points, the ground truth 2562"),
        (PointMap(ALL + 1), IDENTITY, "the map names number 2562 of a target of 2562 points"),
        (IDENTITY, PointMap(np.full(len(ALL), -1)), "the ground truth holds no point"),
    ],
)
def test_maps_that_do_not_fit_are_refused(found, truth, said):
    with pytest.raises(InputError, match=said):
        score_map(found, truth, SPHERE)


def test_limbs_are_counted_on_any_pose_and_swapped_ones_are_mirror_images():
    body = load("human")
    rest, walk = (sample(body[pose], 1500) for pose in ("rest", "walk"))
    here, there = (body.reference.at(scan.face_ids, scan.barycentrics) for scan in (rest, walk))
    right = PointMap(cKDTree(there).query(here)[1])
    swapped = PointMap(cKDTree(there * [-1, 1, 1]).query(here)[1])
    found = score_scans(right, rest, walk, body["walk"], mirror=body.mirror)
    assert (found.right_limb, found.mirror_limb) == (1, 0)
    assert found.errors.mean() == pytest.approx(found.least, rel=0.1)
    found = score_scans(swapped, rest, walk, body.reference, mirror=body.mirror)
    assert (found.right_limb, found.mirror_limb) == (pytest.approx(1 / 5), 1)  # the head stays
    assert score_map(IDENTITY, IDENTITY, SPHERE).right_limb is None

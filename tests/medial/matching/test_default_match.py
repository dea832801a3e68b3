"""The default strategy of `match`, end to end on small clouds."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import datasets_gen
from medial import Diffusion, match
from medial.matching import prepared
from scanner_sim import ScannerConfig, scan
from tests.medial.clouds import body, cylinder, planes, rotation, sphere, torus
from tests.medial.matching.registration.directions import BENT, SMALL
from tests.medial.posed import bent, common_units, figure

MODES = 60


def unit():
    return np.sqrt(figure().areas.sum())


def errors(found, target, truth):
    """Distances from the matched target points to where the source points truly go, in sqrt(area)."""
    return np.linalg.norm(target.points[found.source_to_target] - truth, axis=1) / unit()


def other_sample(kept=lambda points: np.ones(len(points), dtype=bool)):
    """Other points of the figure with bent elbows, without some of them."""
    points, normals = bent(*body(800, seed=3), *BENT)
    kept = kept(points)
    return Diffusion.from_points(points[kept], normals[kept], modes=MODES)


@pytest.fixture(scope="module")
def truth():
    return bent(figure().points, figure().normals, *BENT)[0]


@pytest.fixture(scope="module")
def whole():
    target = other_sample()
    return target, match(figure(), target, SMALL)


@pytest.fixture(scope="module")
def without_arm():
    target = other_sample(lambda points: points[:, 0] < 0.35)
    return target, match(figure(), target, SMALL)


def test_a_search_that_sees_a_part_of_the_points_matches_all(whole, truth, monkeypatch):
    monkeypatch.setattr(prepared, "MOST_POINTS", 300)
    found = match(figure(), whole[0], SMALL)
    assert len(found.source_to_target) == len(figure())
    assert len(np.unique(found.source_to_target)) > 350
    assert errors(found, whole[0], truth).mean() < 1.5 * errors(whole[1], whole[0], truth).mean()


@settings(max_examples=3, deadline=None, derandomize=True, database=None)
@given(st.integers(0, 1000), st.sampled_from([0.01, 1.0, 1000.0]), st.floats(-5, 5))
def test_a_shuffled_moved_and_scaled_copy_is_recovered(seed, scale, shift):
    order = np.random.default_rng(seed).permutation(len(figure()))
    points = scale * (figure().points[order] @ rotation(seed).T + shift)
    target = Diffusion.from_points(points, figure().normals[order] @ rotation(seed).T, modes=MODES)
    found = match(figure(), target, SMALL, seed=seed)
    gap = np.linalg.norm(figure().points[order[found.source_to_target]] - figure().points, axis=1)
    assert gap.mean() / unit() < 0.005
    assert np.median(found.confidence) > 0.9


def test_another_pose_and_sample_is_matched(whole, truth):
    target, found = whole
    gap = errors(found, target, truth)
    assert len(found) == len(figure())
    assert gap.mean() < 0.03
    assert np.mean(gap > 0.1) < 0.02


def test_confident_matches_are_right(whole, truth):
    target, found = whole
    assert found.confidence.min() >= 0
    assert found.confidence.max() <= 1
    sure = found.confidence > 0.5
    assert sure.mean() > 0.8
    assert errors(found, target, truth)[sure].max() < 0.1


def test_landmarks_and_restarts_belong_to_the_map(whole):
    target, found = whole
    source, goal = found.landmarks.T
    assert len(source) > 0
    assert np.array_equal(found.source_to_target[source], goal)
    assert goal.max() < len(target)
    assert found.restarts["chosen"].sum() == 1
    assert found.restarts["paths"].any()
    assert not found.restarts["paths"].all()
    assert np.array_equal(np.isnan(found.restarts["cost"]), found.restarts["paths"])
    assert np.isfinite(found.restarts["score"]).all()
    assert found.mirror_check in {"agrees", "overruled", "undecided"}


def test_a_missing_arm_has_low_confidence(without_arm, truth):
    target, found = without_arm
    arm = figure().points[:, 0] > 0.45
    assert arm.sum() > 30
    assert np.median(found.confidence[arm]) < 0.3 * np.median(found.confidence[~arm])
    assert found.confidence[arm].max() < np.median(found.confidence[~arm])
    assert errors(found, target, truth)[~arm].mean() < 0.03


def test_a_part_is_found_in_the_whole(without_arm):
    """Against the other direction, nothing is missing."""
    source, _ = without_arm
    target = figure()
    found = match(source, target, SMALL)
    goal = bent(target.points, target.normals, *BENT)[0]  # the target's points in the source's pose
    gap = np.linalg.norm(goal[found.source_to_target] - source.points, axis=1) / unit()
    assert gap.mean() < 0.03


@pytest.mark.parametrize(
    "other", [torus, *(pytest.param(each, marks=pytest.mark.slow) for each in (cylinder, planes))]
)
def test_unrelated_clouds_have_low_confidence(whole, other):
    unrelated = Diffusion.from_points(*other(600), modes=MODES)
    found = match(figure(), unrelated, SMALL)
    assert 0 <= np.median(found.confidence) < 0.5 * np.median(whole[1].confidence)
    assert np.mean(found.confidence > 0.5) < 0.2


@pytest.mark.slow
@pytest.mark.long
def test_quick_maps_are_nearly_as_good(whole, truth):
    """Without fine deformation."""
    target, fine = whole
    found = match(figure(), target, replace(SMALL, refine="none"))
    assert errors(found, target, truth).mean() < 0.05
    assert not np.array_equal(found.source_to_target, fine.source_to_target)


@pytest.mark.parametrize("operator", ["medial", "robust"])
def test_spheres_end_undecided(operator):
    """Every rotation is as good as any other."""
    source, target = (Diffusion.from_points(*sphere(n), operator, modes=MODES) for n in (500, 620))
    found = match(source, target, SMALL)
    assert np.isfinite(found.confidence).all()
    assert np.median(found.confidence) < 0.5
    assert found.mirror_check == "undecided"


@pytest.mark.slow
@pytest.mark.long
def test_a_torus_meets_itself_somewhere():
    """It may turn about its axis, but its surface is found."""
    source, target = (Diffusion.from_points(*torus(600, seed=k), modes=MODES) for k in (0, 1))
    found = match(source, target, SMALL)
    here, there = common_units(source, target)
    place = there.points[found.source_to_target]
    assert (
        np.abs(np.linalg.norm(place[:, :2], axis=1) - np.linalg.norm(here.points[:, :2], axis=1)).mean()
        < 0.05
    )
    assert np.median(found.confidence) < 0.5


@pytest.mark.slow
@pytest.mark.parametrize(("other", "told"), [("right:1", True), ("left:1", False)])
def test_scans_of_one_side_each_leave_open_which_limb_is_which(other, told, caplog):
    """From opposite sides no point is believed; from the same side most points are."""
    subject = datasets_gen.load("quadruped")
    scans = [
        scan(subject[pose], ScannerConfig(views=views)).accept(0.3).subsample(1500)
        for pose, views in (("stand", "left:1"), ("trot", other))
    ]
    found = match(*(Diffusion.from_points(each.points, each.normals) for each in scans))
    assert ("limbs of the other side fit as well" in caplog.text) == told
    assert (found.probability < 0.5) == told
    share = (found.confidence >= 0.5).mean()
    assert share == 0 if told else share > 0.3

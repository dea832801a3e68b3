"""Following a map, settling, and the score that tells a right map from a wrong one."""

import numpy as np
import pytest

from medial.matching.registration.deformation_graph import Pose
from medial.matching.registration.evidence import WEIGHTS
from medial.matching.registration.registration import NORMAL_LENGTH, SEEN_WITHIN, Schedule, features, found
from tests.medial.clouds import rotation, sphere
from tests.medial.posed import (
    Setup,
    bent_figure,
    error,
    figure,
    left_arm,
    legs,
    mapped,
    rest_pose,
    right_arm,
    rigid_pose,
)

SCHEDULE = Schedule()


@pytest.fixture(scope="module")
def at_rest():
    return Setup(figure())


@pytest.fixture(scope="module")
def slightly():
    """The target has its elbows slightly bent."""
    return Setup(bent_figure(0.35, -0.35))


@pytest.fixture(scope="module")
def strongly():
    return Setup(bent_figure(1.0, 0.8))


def on_arms(setup):
    points = setup.points * setup.unit
    return right_arm(points) | left_arm(points)


def test_what_coincides_is_found():
    points, normals = sphere(100)
    assert np.allclose(found(points, normals, points, normals), 1)


def test_found_falls_with_distance():
    points, normals = sphere(50)
    side = np.array([1.0, 0, 0])
    seen = [found(points, normals, points + d * side, normals) for d in (0, 0.01, SEEN_WITHIN, 0.1, 1.0)]
    assert (np.diff(seen, axis=0) < 0).all()
    assert np.allclose(seen[2], 0.5)
    assert (seen[-1] < 0.01).all()


def test_found_falls_with_the_angle_of_normals():
    angle = np.array([0, 0.3, 0.8, 1.5, 2.0, np.pi])
    normals = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    origin = np.zeros((6, 3))
    seen = found(origin, normals, origin, np.tile([1.0, 0, 0], (6, 1)))
    assert seen[:4] == pytest.approx(np.cos(angle[:4]) ** 2)
    assert (seen[4:] == 0).all()  # seen from behind


def test_found_is_a_share():
    random = np.random.default_rng(0)
    points, goals = random.standard_normal((2, 200, 3)) * 0.05
    normals, others = (x / np.linalg.norm(x, axis=1, keepdims=True) for x in random.normal(size=(2, 200, 3)))
    seen = found(points, normals, goals, others)
    assert seen.min() == 0
    assert 0.1 < seen.max() <= 1


def test_features_add_lengths_and_turns_of_normals():
    points, normals = sphere(60)
    joined = features(points, normals[::-1])
    square = ((joined[0] - joined) ** 2).sum(axis=1)
    apart = ((points[0] - points) ** 2).sum(axis=1)
    turned = ((normals[::-1][0] - normals[::-1]) ** 2).sum(axis=1)
    assert np.allclose(square, apart + NORMAL_LENGTH**2 * turned)
    here = np.zeros((1, 3))
    flipped = features(here, np.array([[0, 0, 1.0]])) - features(here, np.array([[0, 0, -1.0]]))
    assert np.linalg.norm(flipped) == pytest.approx(2 * NORMAL_LENGTH)


def test_the_identity_scores_best(at_rest):
    fit = at_rest.registration.judge(rest_pose(at_rest.graph))
    assert fit.seen == pytest.approx(2, abs=0.2)  # samples look back for samples: a little apart
    assert np.allclose(fit.found, 1)
    assert np.array_equal(fit.partner, at_rest.samples)
    assert fit.strain < 1e-20
    assert np.allclose(fit.moved, at_rest.points)


def test_the_score_is_what_is_seen_and_held_less_the_strain(at_rest):
    pose = rest_pose(at_rest.graph)
    pose.positions[:5] += 0.5
    fit = at_rest.registration.judge(pose)
    assert fit.strain > 1e-6
    assert fit.held < 0.9
    seen = fit.found.mean() + fit.found_back.mean()
    assert fit.score == pytest.approx(seen + WEIGHTS.held * fit.held - WEIGHTS.strain * fit.strain)
    assert fit.strain == at_rest.graph.strain(pose)
    assert fit.held == at_rest.graph.held(pose).mean()


def test_far_away_nothing_is_found(at_rest):
    fit = at_rest.registration.judge(rigid_pose(at_rest.graph, np.eye(3), [3.0, 0, 0]))
    assert fit.seen < 0.01


def test_a_slight_bend_is_recovered_from_rest(slightly):
    start = rest_pose(slightly.graph)
    arms = on_arms(slightly)
    before = error(slightly, start, 0.35, -0.35)
    fit = slightly.registration.settle(start, SCHEDULE)
    after = error(slightly, fit, 0.35, -0.35)
    assert before[arms].mean() > 0.03
    assert after[arms].mean() < 0.005
    assert after.mean() < 0.01
    assert fit.score > slightly.registration.judge(start).score


def test_settling_can_be_interrupted(slightly):
    start = rest_pose(slightly.graph)
    whole = slightly.registration.settle(start, SCHEDULE)
    half = slightly.registration.settle(start, SCHEDULE, 0, 5)
    again = slightly.registration.settle(half.pose, SCHEDULE, 5)
    assert np.array_equal(again.moved, whole.moved)
    assert not np.array_equal(half.moved, whole.moved)


def test_a_map_is_followed(strongly):
    pose = strongly.registration.follow(*strongly.bent(1.0, 0.8), SCHEDULE)
    assert error(strongly, rest_pose(strongly.graph), 1.0, 0.8)[on_arms(strongly)].mean() > 0.08
    assert error(strongly, pose, 1.0, 0.8)[on_arms(strongly)].mean() < 0.01


def test_a_map_with_outliers_is_followed(strongly):
    goal, normals = (x.copy() for x in strongly.bent(1.0, 0.8))
    random = np.random.default_rng(0)
    wrong = random.permutation(len(goal))[: len(goal) // 5]
    anywhere = random.integers(len(strongly.target), size=len(wrong))
    goal[wrong], normals[wrong] = strongly.target.points[anywhere], strongly.target.normals[anywhere]
    assert np.linalg.norm(goal - strongly.bent(1.0, 0.8)[0], axis=1).mean() > 0.05
    pose = strongly.registration.follow(goal, normals, SCHEDULE)
    assert error(strongly, pose, 1.0, 0.8).mean() < 0.01


def test_a_rotated_target_is_followed(at_rest):
    turn, shift = rotation(3), np.array([1.0, 2.0, -1.0])
    pose = at_rest.registration.follow(at_rest.points @ turn.T + shift, at_rest.normals @ turn.T, SCHEDULE)
    rigid: Pose = rigid_pose(at_rest.graph, turn, shift)
    assert np.allclose(pose.positions, rigid.positions, atol=1e-6)
    assert np.allclose(pose.rotations, rigid.rotations, atol=1e-5)


@pytest.mark.parametrize("wrong", ["mirrored", "arms", "legs"])
def test_the_true_pose_scores_above_a_wrong_one(strongly, wrong):
    points = strongly.points * strongly.unit
    among = {
        "mirrored": np.ones(len(points), dtype=bool),
        "arms": right_arm(points) | left_arm(points),
        "legs": legs(points),
    }[wrong]
    assert among.sum() > 20
    right, other = (
        strongly.registration.settle(strongly.registration.follow(*goal, SCHEDULE), SCHEDULE)
        for goal in (strongly.bent(1.0, 0.8), mapped(strongly, among, 1.0, 0.8))
    )
    assert error(strongly, right, 1.0, 0.8).mean() < 0.01
    assert error(strongly, other, 1.0, 0.8)[among].mean() > 0.1
    assert right.score > other.score + 0.1

"""Principal axes onto principal axes, and what settles from there."""

import numpy as np
import pytest

from medial.matching.landmarks.rigid_starts import axis_rotations, principal_axes, rigid_poses
from medial.matching.registration.placement import place
from tests.medial.clouds import rotation
from tests.medial.matching.registration.directions import Directions
from tests.medial.posed import Setup, figure


@pytest.fixture(scope="module")
def graph():
    return Setup(figure()).graph


def test_the_rotations_are_all_that_take_axes_to_axes():
    source, target = rotation(1), rotation(2)
    turns = axis_rotations(source, target)
    assert turns.shape == (24, 3, 3)
    assert np.allclose(np.linalg.det(turns), 1)
    assert np.allclose(turns @ turns.transpose(0, 2, 1), np.eye(3))
    cosines = target.T @ turns @ source
    assert np.allclose(np.sort(np.abs(cosines), axis=2), [0, 0, 1])
    assert len(np.unique(cosines.round(6), axis=0)) == 24


def test_principal_axes_turn_with_the_points():
    points = np.random.default_rng(0).standard_normal((50, 3)) * [1, 2, 3]
    turn = rotation(5)
    cosines = principal_axes(points @ turn.T).T @ turn @ principal_axes(points)
    assert np.allclose(np.abs(cosines), np.eye(3))


def test_one_of_the_poses_undoes_a_rigid_motion(graph):
    points = figure().points / np.sqrt(figure().areas.sum())
    turn, shift = rotation(3), np.array([0.3, -2.0, 1.0])
    poses = rigid_poses(graph, points, points @ turn.T + shift)
    gaps = [np.abs(pose.positions - (graph.rest @ turn.T + shift)).max() for pose in poses]
    best = poses[int(np.argmin(gaps))]
    assert min(gaps) < 1e-9
    assert np.allclose(best.rotations, turn)
    assert np.sort(gaps)[1] > 0.1


def test_every_pose_is_rigid(graph):
    points = figure().points / np.sqrt(figure().areas.sum())
    for pose in rigid_poses(graph, points, points @ rotation(7).T):
        assert graph.strain(pose) < 1e-20


def test_the_pose_is_found_without_landmarks():
    directions = Directions()
    for direction in directions.all:
        best = max(direction.from_rigid_motions(), key=lambda fit: fit.score)
        assert np.linalg.norm(place(best).places - directions.true_places, axis=1).mean() < 0.03

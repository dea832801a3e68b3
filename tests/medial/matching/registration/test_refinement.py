"""From a pose to a dense map."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from datasets_gen.points.farthest import farthest_from_mean
from medial.matching.common_units import MOST_POINTS
from medial.matching.landmarks.samples import spectral_samples
from medial.matching.neighbourhoods import neighbourhoods
from medial.matching.registration.deformation_graph import NodeGraph
from medial.matching.registration.refinement import FineDeformation
from tests.medial.clouds import rotation
from tests.medial.posed import bent_figure, common_units, figure, rest_pose, rigid_pose


def fine(target, nodes=80, seen=MOST_POINTS):
    here, there = common_units(figure(), target)
    samples = spectral_samples(figure(), 250, np.random.default_rng(0))
    covers = tuple(farthest_from_mean(cloud.points, seen) for cloud in (here, there))
    return FineDeformation(here, there, covers, neighbourhoods(figure()), samples, nodes)


@pytest.fixture(scope="module")
def same():
    return fine(figure())


def spacing(points):
    return np.median(cKDTree(points).query(points, k=2)[0][:, 1])


def gaps(deformation, mapped):
    """Distance on the source between points and what they are mapped to, where targets share their order."""
    return np.linalg.norm(deformation.source.points[mapped] - deformation.source.points, axis=1)


@pytest.mark.parametrize("direction", [FineDeformation.dense, FineDeformation.inverse])
def test_the_rest_pose_is_the_identity(same, direction):
    dense = direction(same, same.judge(rest_pose(same.graph)))
    assert np.array_equal(dense.match, np.arange(len(same.source)))
    assert np.allclose(dense.found, 1)
    assert np.allclose(dense.held, 1)
    assert dense.alone.min() > 0.9


def test_settling_keeps_the_identity(same):
    dense = same.dense(same.settle(rest_pose(same.graph)))
    assert gaps(same, dense.match).mean() < 0.1 * spacing(same.source.points)
    assert gaps(same, dense.match).max() < 2 * spacing(same.source.points)


def test_settling_follows_a_bend():
    deformation = fine(bent_figure(0.5, -0.5))
    before = deformation.dense(deformation.judge(rest_pose(deformation.graph))).match
    after = deformation.dense(deformation.settle(rest_pose(deformation.graph))).match
    assert gaps(deformation, before).mean() > 0.004
    assert gaps(deformation, after).mean() < gaps(deformation, before).mean() / 3


@pytest.mark.parametrize("direction", [FineDeformation.dense, FineDeformation.inverse])
def test_of_a_large_cloud_some_points_settle_and_all_are_matched(direction):
    deformation = fine(bent_figure(0.5, -0.5), seen=300)
    fit = deformation.settle(rest_pose(deformation.graph))
    assert len(fit.moved) == 300
    assert len(np.unique(fit.partner)) <= 300
    dense = direction(deformation, fit)
    assert len(dense.match) == len(figure())
    assert len(np.unique(dense.match)) > 500
    assert gaps(deformation, dense.match).mean() < 0.01


def test_a_coarse_pose_is_carried_over_to_the_fine_nodes(same):
    coordinates = neighbourhoods(figure())
    coarse, hang = NodeGraph.over(coordinates, same.source.points, np.arange(len(figure())), 20)
    turn, shift = rotation(2), np.array([0.5, -1.0, 0.2])
    pose, rigid = (
        same.adopt(coarse, hang, rigid_pose(coarse, turn, shift)),
        rigid_pose(same.graph, turn, shift),
    )
    assert np.allclose(pose.positions, rigid.positions, atol=1e-5)
    assert np.allclose(pose.rotations, rigid.rotations, atol=1e-4)


def collapsed(deformation):
    """The right arm shifted onto the left one."""
    unit = np.linalg.norm(figure().points[0]) / np.linalg.norm(deformation.source.points[0])
    place = deformation.graph.rest * unit
    right, left = place[:, 0] > 0.35, place[:, 0] < -0.4
    pose = rest_pose(deformation.graph)
    pose.positions[right] += (place[left].mean(axis=0) - place[right].mean(axis=0)) / unit
    return pose, figure().points[:, 0] > 0.45, figure().points[:, 0] < -0.5


def test_strangers_meet_where_parts_collapse_onto_each_other(same):
    pose, right, left = collapsed(same)
    dense = same.dense(same.judge(pose))
    torso = np.abs(figure().points).max(axis=1) < 0.28
    assert min(right.sum(), left.sum(), torso.sum()) > 30
    assert np.median(dense.alone[right]) < 0.7
    assert np.median(dense.alone[left]) < 0.75
    assert np.median(dense.alone[torso]) > 0.95
    assert (dense.alone >= 0).all()
    assert (dense.alone <= 1).all()


def test_what_was_torn_off_is_not_held(same):
    pose, right, left = collapsed(same)
    held = same.dense(same.judge(pose)).held
    assert held[right].max() < 0.6
    assert held[left].min() > 0.8


def test_what_moved_away_is_not_found(same):
    pose = rest_pose(same.graph)
    arm = same.graph.rest[:, 0] > same.graph.rest[:, 0].max() - 0.1
    pose.positions[arm] += [1.0, 0, 0]
    found = same.dense(same.judge(pose)).found
    tip = figure().points[:, 0] > 0.95
    assert tip.any()
    assert found[tip].max() < 0.2
    assert np.allclose(found[figure().points[:, 0] < 0], 1)


def test_the_inverse_undoes_the_map():
    deformation = fine(bent_figure(0.5, -0.5))
    fit = deformation.settle(rest_pose(deformation.graph))
    there, back = deformation.dense(fit), deformation.inverse(fit)
    again = back.match[there.match]
    gap = np.linalg.norm(deformation.source.points[again] - deformation.source.points, axis=1)
    assert np.median(gap) < spacing(deformation.source.points)
    assert np.mean(gap > 3 * spacing(deformation.source.points)) < 0.02
    assert len(back.match) == len(deformation.target)

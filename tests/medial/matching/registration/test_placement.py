"""What fits of both directions are compared by."""

import numpy as np
import pytest

from medial.matching.common_units import common_units
from medial.matching.registration.deformation_graph import Pose
from medial.matching.registration.direction import BALLS, DirectedFit
from medial.matching.registration.evidence import WEIGHTS, medial_gap
from medial.matching.registration.placement import (
    ALIKE,
    Placement,
    path_change,
    place,
    unmoved,
    unmoved_share,
)
from tests.medial.matching.registration.directions import Directions, true_landmarks
from tests.medial.posed import figure, legs, right_arm


@pytest.fixture(scope="module")
def directions():
    return Directions()


@pytest.fixture(scope="module")
def right(directions):
    """The fit of the true landmarks, source onto target."""
    return directions.best(directions.settled(true_landmarks()))[0]


def test_the_gap_of_placements_is_their_mean_distance():
    here = Placement(np.zeros((4, 3)), 1.0)
    there = Placement(np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 1.0]]), 1.0)
    assert here.gap(there) == 1.0
    assert there.gap(here) == 1.0


@pytest.mark.parametrize(("shift", "alike"), [(0.5 * ALIKE, True), (2.0 * ALIKE, False)])
def test_maps_that_differ_little_on_average_are_alike(shift, alike):
    one = Placement(np.zeros((4, 3)), 1.6)
    assert one.like(Placement(np.full((4, 3), shift / np.sqrt(3)), 1.5)) == alike


def test_a_limb_on_another_costs_what_it_changes_along_the_body(directions, right):
    lost = directions.all[0].follow([directions.astray])[0]
    loss, right_loss = (fit.score - place(fit).score for fit in (lost, right))
    assert loss == pytest.approx(WEIGHTS.paths * path_change(lost))
    assert loss > right_loss + 0.1 >= 0.1


def test_paths_change_as_much_seen_from_either_side(directions, right):
    """A fit and its inverse differ in strain, but what they do to paths compares."""
    inverted = directions.all[1].invert([right])[0]
    here = path_change(right)
    assert path_change(inverted) == pytest.approx(here, abs=0.01)


def test_without_path_lengths_the_score_is_that_of_the_fit():
    bare = Directions(paths=False)
    fit = bare.best(bare.settled(true_landmarks()))[0]
    assert place(fit).score == fit.score


def unmoved_fit(direction):
    rest = direction.graph.rest
    pose = Pose(np.tile(np.eye(3), (len(rest), 1, 1)), rest)
    return DirectedFit(**vars(direction.registration.judge(pose)), direction=direction)


def test_medial_balls_of_a_limb_elsewhere_do_not_meet(directions, right):
    lost = directions.all[0].follow([directions.astray])[0]
    assert lost.medial_gap > right.medial_gap + 0.01


def test_where_nothing_moves_the_medial_gap_is_that_of_the_samples(directions):
    direction = directions.all[0]
    here, there = direction.source, direction.target
    samples, balls = here.descriptors.samples, there.cover[:BALLS]
    still = unmoved_fit(direction)
    expected = medial_gap(
        here.cloud.centers[samples],
        here.cloud.radii[samples],
        there.cloud.centers[balls],
        there.cloud.radii[balls],
    )
    assert still.medial_gap == pytest.approx(expected, abs=1e-6)


def test_between_two_clouds_nothing_has_to_move(right):
    assert unmoved(right) == 0


def test_only_what_leaves_its_medial_region_moves():
    cloud = common_units(figure(), figure())[0]
    points = np.arange(len(cloud))
    arm, leg = right_arm(figure().points), legs(figure().points)
    images = points.copy()
    images[arm] = np.flatnonzero(leg)[0]
    assert unmoved_share(cloud, points, points) == 1
    assert unmoved_share(cloud, points, images) == pytest.approx(1 - arm.mean())
    assert unmoved_share(cloud, points[:0], points[:0]) == 0

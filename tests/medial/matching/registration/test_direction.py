"""Deforming one cloud of a pair onto the other, in either direction."""

import numpy as np
import pytest

from medial import match
from medial.matching.registration.placement import place
from tests.medial.matching.registration.directions import Directions, true_landmarks
from tests.medial.matching.test_default_match import SMALL, errors, other_sample, truth  # noqa: F401
from tests.medial.posed import figure


@pytest.fixture(scope="module")
def directions():
    return Directions()


@pytest.fixture(scope="module")
def settled(directions):
    return directions.settled(true_landmarks())


def test_both_directions_find_the_same_map(directions, settled):
    for fit in directions.best(settled):
        assert np.linalg.norm(place(fit).places - directions.true_places, axis=1).mean() < 0.03


def test_every_fit_knows_its_direction(directions, settled):
    forward, backward = directions.all
    assert {id(fit.direction) for fit in settled} == {id(forward), id(backward)}
    assert [fit.backward for fit in settled] == sorted(fit.backward for fit in settled)
    for made in (forward.from_rigid_motions, lambda: forward.exchange(settled[:1])):
        assert all(fit.direction is forward for fit in made())


def test_an_arm_that_went_astray_is_pulled_back(directions):
    forward = directions.all[0]
    settled = forward.settle(forward.follow([directions.astray]))
    gaps = [np.linalg.norm(place(fit).places - directions.true_places, axis=1).mean() for fit in settled]
    best = max(range(len(settled)), key=lambda k: settled[k].score)
    assert gaps[0] > 0.05  # settled softly it stays where it is
    assert gaps[best] < 0.03


def test_an_inverted_fit_is_the_same_map(directions, settled):
    fit = directions.best(settled)[0]
    inverted = directions.all[1].invert([fit])[0]
    assert inverted.backward
    assert place(inverted).gap(place(fit)) < 0.03


def test_the_inverse_sends_target_samples_to_source_samples(directions, settled):
    fit = directions.best(settled)[0]
    source, target = directions.pair.source, directions.pair.target
    inverse = fit.inverse
    assert len(inverse) == len(target.descriptors.samples)
    assert np.isin(inverse, source.descriptors.samples).all()
    gap = source.cloud.points[inverse] - source.cloud.points[target.descriptors.samples]
    assert np.median(np.linalg.norm(gap, axis=1)) < 0.05  # target points have the source's order


def test_there_is_one_direction_unless_both_are_wanted():
    assert len(Directions(both_ways=False).all) == 1


def test_roles_may_be_swapped(truth):  # noqa: F811
    """What one direction finds the other one finds too."""
    target = other_sample(lambda points: points[:, 0] < 0.35)
    there, back = match(figure(), target, SMALL), match(target, figure(), SMALL)
    kept = figure().points[:, 0] < 0.3
    assert errors(there, target, truth)[kept].mean() < 0.03
    again = there.source_to_target[back.source_to_target]  # to the figure and back to the target
    unit = np.sqrt(figure().areas.sum())
    gap = np.linalg.norm(target.points[again] - target.points, axis=1) / unit
    assert np.median(gap) < 0.03

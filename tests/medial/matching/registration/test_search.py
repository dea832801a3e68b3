"""The search among fits of both directions."""

from dataclasses import replace

import numpy as np
import pytest

from medial import match
from medial.matching.registration.direction import LIKE, Direction
from medial.matching.registration.evidence import promise
from medial.matching.registration.exchange import SAME_FIT, distinct
from medial.matching.registration.placement import place
from medial.matching.registration.search import (
    CONFIRMED,
    INVERTED,
    forward_first,
    half_turned,
    moving,
    of,
    promises,
    search,
)
from tests.medial.matching.registration.directions import BENT, SMALL, Directions, true_landmarks
from tests.medial.posed import bent_figure, figure, right_arm


@pytest.fixture(scope="module")
def directions():
    return Directions()


@pytest.fixture(scope="module")
def found(directions):
    """What the search makes of the fits of true landmarks."""
    return search(directions.all, directions.settled(true_landmarks()))


def test_both_directions_end_at_the_same_map(directions, found):
    for fit in directions.best(found):
        assert np.linalg.norm(place(fit).places - directions.true_places, axis=1).mean() < 0.03


def test_fits_come_forward_first_and_best_first(directions, found):
    assert forward_first(reversed(found))[0].backward is False
    assert [fit.backward for fit in found] == sorted(fit.backward for fit in found)
    for each in directions.all:
        scores = [fit.score for fit in of(each, found)]
        assert scores == sorted(scores, reverse=True)


def test_a_direction_without_good_candidates_learns_from_the_other(directions, found):
    forward, backward = directions.all
    lost = np.zeros(
        len(directions.pair.target.descriptors.samples), dtype=np.int64
    )  # everything to one point
    nothing = replace(directions.given(np.zeros((1, 2), dtype=np.int64))[1], at_samples=lost)
    alone = backward.settle(backward.follow([nothing]))[0]
    known = forward.settle(forward.follow(directions.given(np.array([[0, 0]]))[:1]))
    told = of(backward, search(directions.all, [*known, alone]))
    truth_score = of(backward, found)[0].score
    assert alone.score < truth_score - 0.3
    assert told[0].score > alone.score


def test_fits_that_differ_in_one_hand_are_both_looked_at(directions, found):
    alone = Directions(both_ways=False, recombine=False)
    right = replace(found[0], direction=alone.all[0])
    moved = right.moved.copy()
    moved[right_arm(figure().points[directions.pair.source.descriptors.samples])] += (0, 0, 0.3)
    gap = np.linalg.norm(moved - right.moved, axis=1).mean()
    assert LIKE < gap < SAME_FIT
    other = replace(right, moved=moved)
    assert len(distinct([right, other], 2)) == 1
    assert len(search(alone.all, [right, other])) == 2


def test_with_one_direction_nothing_is_inverted():
    alone = Directions(both_ways=False)
    fits = search(alone.all, alone.settled(np.array([[0, 0], [300, 300]])))
    assert not any(fit.backward for fit in fits)


def test_what_stays_in_place_counts_only_if_all_does(found, monkeypatch):
    monkeypatch.setattr("medial.matching.registration.search.unmoved", lambda fit: float(fit is found[0]))
    assert moving(found) == found[1:]
    assert moving(found[:1]) == found[:1]
    assert promises(found[:1]) == [-np.inf]
    assert np.isfinite(promises(found[1:])).all()


def test_a_fit_promises_what_its_placement_does(found):
    for fit, value in zip(found, promises(found), strict=True):
        at = place(fit)
        assert value == promise(fit.weights, at.score, fit.medial_gap)


@pytest.mark.parametrize(("sure", "made"), [(-1e9, 0), (1e9, 1)])
def test_rivals_are_made_where_no_fit_promises_enough(monkeypatch, sure, made):
    calls = []

    def watched(directions, fits, promised):
        calls.append(fits)
        assert promised == promises(fits)
        return half_turned(directions, fits, promised)

    monkeypatch.setattr("medial.matching.fit_search.SURE", sure)
    monkeypatch.setattr("medial.matching.fit_search.half_turned", watched)
    match(figure(), bent_figure(*BENT), SMALL)
    assert len(calls) == made


@pytest.mark.parametrize(("sure", "exchanges"), [(True, 0), (False, 2)])
def test_parts_are_exchanged_unless_a_fit_is_sure(directions, found, monkeypatch, sure, exchanges):
    asked, inverted = [], []
    exchange, invert = Direction.exchange, Direction.invert
    monkeypatch.setattr(Direction, "exchange", lambda self, fits: asked.append(self) or exchange(self, fits))
    monkeypatch.setattr(
        Direction, "invert", lambda self, fits: inverted.append(len(fits)) or invert(self, fits)
    )
    ended = search(directions.all, found, sure)
    assert len(asked) == exchanges
    assert max(inverted) <= (CONFIRMED if sure else INVERTED)
    assert max(fit.score for fit in ended) >= max(fit.score for fit in found)


def test_rivals_are_made_of_the_most_promising_fit_of_each_direction(directions, found, monkeypatch):
    turned = []
    monkeypatch.setattr(Direction, "half_turns", lambda self, fit: turned.append(fit) or [])
    assert half_turned(directions.all, found, promises(found)) == []
    assert turned == [max(of(each, found), key=lambda fit: promises([fit])[0]) for each in directions.all]

"""The search among fits of both directions."""

from dataclasses import replace

import numpy as np
import pytest

from medial import match
from medial.matching.registration.direction import LIKE
from medial.matching.registration.exchange import SAME_FIT, distinct
from medial.matching.registration.placement import place
from medial.matching.registration.search import forward_first, moving, of, search, surely_seen
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
    assert surely_seen(found[:1]) == 0
    assert surely_seen(found) == max(fit.seen for fit in found[1:])


@pytest.mark.parametrize(("enough", "barely", "times"), [(0.0, 0.0, 1), (2.0, 0.0, 2), (2.0, 2.0, 1)])
def test_the_search_goes_on_once_more_where_too_little_meets(monkeypatch, enough, barely, times):
    best = []

    def watched(directions, fits):
        found = search(directions, fits)
        best.append(tuple(max(f.score for f in some) for some in (fits, found)))
        return found

    monkeypatch.setattr("medial.matching.fit_search.ENOUGH", enough)
    monkeypatch.setattr("medial.matching.fit_search.BARELY", barely)
    monkeypatch.setattr("medial.matching.fit_search.search", watched)
    match(figure(), bent_figure(*BENT), SMALL)
    assert len(best) == times
    assert all(after >= before for before, after in best)
    assert best[-1][0] >= best[0][1]  # from where it ended

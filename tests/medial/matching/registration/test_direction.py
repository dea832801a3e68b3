"""Both ways to match a pair, and what they tell each other."""

from dataclasses import replace

import numpy as np
import pytest

from medial import match
from medial.matching.match import Pair
from medial.matching.registration.direction import ALIKE, LIKE, Placed, Sets, search
from medial.matching.registration.exchange import SAME_FIT, distinct
from tests.medial.matching.test_default_match import BENT, SMALL, errors, other_sample, truth  # noqa: F401
from tests.medial.posed import bent_figure, figure, legs, right_arm


@pytest.fixture(scope="module")
def pair():
    return Pair(figure(), bent_figure(*BENT), SMALL, 0)


@pytest.fixture(scope="module")
def found(pair):
    """Each way from one true landmark set, the other one's landmarks turned round."""
    landmarks = np.repeat(np.linspace(0, len(figure()) - 1, 7).astype(np.int64)[:, None], 2, axis=1)
    return search(pair.ways, settled(pair, landmarks))


def settled(pair, landmarks):
    return [w.settle(w.follow(c)) for w, c in zip(pair.ways, pair.given(landmarks), strict=True)]


def true_places(pair):
    return pair.ends[1].cloud.points[pair.ends[0].side.samples]  # target points have the source's order


def test_both_ways_find_the_same_map(pair, found):
    for way, fits in zip(pair.ways, found, strict=True):
        places = way.placed(fits[0]).places
        assert np.linalg.norm(places - true_places(pair), axis=1).mean() < 0.03


def astray(pair):
    """A candidate of the source that is right but for an arm, which goes to the feet."""
    goal = pair.ends[0].side.samples.copy()  # target points have the source's order
    goal[right_arm(figure().points[goal])] = np.flatnonzero(legs(figure().points))[0]
    return replace(pair.given(np.array([[0, 0]]))[0][0], at_samples=goal)


def test_an_arm_that_went_astray_is_pulled_back(pair):
    there = pair.ways[0]
    settled = there.settle(there.follow([astray(pair)]))
    gaps = [np.linalg.norm(there.placed(fit).places - true_places(pair), axis=1).mean() for fit in settled]
    best = max(range(len(settled)), key=lambda k: settled[k].score)
    assert gaps[0] > 0.05  # settled softly it stays where it is
    assert gaps[best] < 0.03


def test_a_fit_turned_round_is_the_same_map(pair, found):
    there, back = pair.ways
    turned = back.turned(there, found[0][:1])[0]
    assert back.placed(turned).gap(there.placed(found[0][0])) < 0.03


def test_a_way_without_good_candidates_learns_from_the_other(pair, found):
    there, back = pair.ways
    lost = np.zeros(len(pair.ends[1].side.samples), dtype=np.int64)  # everything to one point
    nothing = replace(pair.given(np.zeros((1, 2), dtype=np.int64))[1][0], at_samples=lost)
    alone = back.settle(back.follow([nothing]))[0]
    known = there.settle(there.follow(pair.given(np.array([[0, 0]]))[0]))
    told = search(pair.ways, [known, [alone]])
    truth_score = found[1][0].score
    assert alone.score < truth_score - 0.3
    assert told[1][0].score > alone.score


def test_a_limb_on_another_has_less_merit_than_its_score_says(pair, found):
    way, right = pair.ways[0], found[0][0]
    lost = way.follow([astray(pair)])[0]
    before, after = way.placed(right), way.placed(lost)
    assert before.score == right.score
    assert before.merit <= before.score
    assert after.score - after.merit > before.score - before.merit + 0.2


def test_paths_change_as_much_seen_from_either_side(pair, found):
    """A fit and the same one turned round differ in strain, but what they do to paths compares."""
    there, back = pair.ways
    for fit in found[0][:2]:
        turned = back.turned(there, [fit])[0]
        here = there.changed(fit, there.reaching(fit))
        assert back.changed(turned, back.reaching(turned)) == pytest.approx(here, abs=0.01)


def test_without_path_lengths_merit_is_the_score(found):
    way = Pair(figure(), bent_figure(*BENT), replace(SMALL, paths=False), 0).ways[0]
    placed = way.placed(found[0][0])
    assert placed.merit == placed.score == found[0][0].score


@pytest.mark.parametrize(("shift", "lead"), [(0.5 * ALIKE, -0.3), (2.0 * ALIKE, 0.1)])
def test_paths_compare_maps_that_are_alike_and_scores_other_maps(shift, lead):
    one = Placed(np.zeros((4, 3)), 1.6, 1.0)
    other = Placed(np.full((4, 3), shift / np.sqrt(3)), 1.5, 1.3)
    assert one.lead(other) == pytest.approx(lead)
    assert other.lead(one) == pytest.approx(-lead)


def test_fits_that_differ_in_one_hand_are_both_looked_at(pair, found):
    right = found[0][0]
    moved = right.moved.copy()
    moved[right_arm(figure().points[pair.ends[0].side.samples])] += (0, 0, 0.3)
    gap = np.linalg.norm(moved - right.moved, axis=1).mean()
    assert LIKE < gap < SAME_FIT
    other = replace(right, moved=moved)
    assert len(distinct([right, other], 2)) == 1
    alone = replace(SMALL, both_ways=False, recombine=False)
    ways = Pair(figure(), bent_figure(*BENT), alone, 0).ways
    assert len(search(ways, [[right, other]])[0]) == 2


def test_without_another_way_nothing_is_handed_over():
    pair = Pair(figure(), bent_figure(*BENT), replace(SMALL, both_ways=False), 0)
    assert len(pair.ways) == 1
    fits = search(pair.ways, settled(pair, np.array([[0, 0], [300, 300]])))
    assert len(fits) == 1


def test_the_second_helping_takes_the_first_landmarks_that_are_left(pair):
    draw = Sets(pair.ways, [np.random.default_rng(k) for k in (0, 1)])
    first, more = ([c for c in found[0] if not c.by_paths] for found in (draw.first(), draw.more()))
    after = {int(c.landmarks[0, 0]) for c in more}
    assert len(after) == SMALL.restarts // 2
    assert int(first[0].landmarks[0, 0]) not in after


@pytest.mark.parametrize(("enough", "helpings"), [(0.0, 1), (2.0, 2)])
def test_more_sets_are_tried_only_where_the_first_do_not_do(monkeypatch, enough, helpings):
    monkeypatch.setattr("medial.matching.match.ENOUGH", enough)
    found = match(figure(), bent_figure(*BENT), SMALL)
    sets = Sets(
        Pair(figure(), bent_figure(*BENT), SMALL, 0).ways, [np.random.default_rng([0, k]) for k in (2, 3)]
    )
    count = sum(map(len, sets.first())) + (sum(map(len, sets.more())) if helpings == 2 else 0)
    assert len(found.restarts["cost"]) == count


@pytest.mark.parametrize(("enough", "barely", "times"), [(0.0, 0.0, 1), (2.0, 0.0, 2), (2.0, 2.0, 1)])
def test_the_search_goes_on_once_more_where_too_little_meets(monkeypatch, enough, barely, times):
    best = []

    def watched(ways, fits):
        found = search(ways, fits)
        best.append(tuple(max(f.score for each in some for f in each) for some in (fits, found)))
        return found

    monkeypatch.setattr("medial.matching.match.ENOUGH", enough)
    monkeypatch.setattr("medial.matching.match.BARELY", barely)
    monkeypatch.setattr("medial.matching.match.search", watched)
    match(figure(), bent_figure(*BENT), SMALL)
    assert len(best) == times
    assert all(after >= before for before, after in best)
    assert best[-1][0] >= best[0][1]  # from where it ended


def test_the_gap_of_placements_is_their_mean_distance():
    here = Placed(np.zeros((4, 3)), 1.0, 1.0)
    there = Placed(np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 1.0]]), 1.0, 1.0)
    assert here.gap(there) == 1.0
    assert there.gap(here) == 1.0


def test_the_table_of_restarts_says_which_way():
    target = bent_figure(*BENT)
    both, one = match(figure(), target, SMALL), match(figure(), target, replace(SMALL, both_ways=False))
    assert both.restarts["backward"].any()
    assert not both.restarts["backward"].all()
    assert not one.restarts["backward"].any()
    back = both.restarts["backward"]
    for column in ("first", "partner"):  # every set is tried both ways
        assert np.array_equal(both.restarts[column][back], both.restarts[column][~back])


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

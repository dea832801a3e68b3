"""Which candidates are tried, in which direction."""

from dataclasses import replace

import numpy as np
import pytest

from medial import match
from medial.matching.candidate_batches import first_batch, first_landmarks_of, second_batch
from tests.medial.matching.registration.directions import BENT, SMALL, Directions
from tests.medial.posed import bent_figure, figure


@pytest.fixture(scope="module")
def directions():
    return Directions()


@pytest.fixture(scope="module")
def batches(directions):
    starts = first_landmarks_of(directions.all)
    return first_batch(directions.all, starts), second_batch(directions.all, starts)


def test_the_second_batch_takes_the_first_landmarks_that_are_left(batches):
    first, more = ([c for c in batch if not (c.by_paths or c.backward)] for batch in batches)
    after = {int(c.landmarks[0, 0]) for c in more}
    assert len(after) == SMALL.restarts // 2
    assert int(first[0].landmarks[0, 0]) not in after


def test_with_one_direction_the_first_batch_has_all():
    alone = Directions(both_ways=False)
    starts = first_landmarks_of(alone.all)
    first = [c for c in first_batch(alone.all, starts) if not c.by_paths]
    assert len({int(c.landmarks[0, 0]) for c in first}) == SMALL.restarts
    assert second_batch(alone.all, starts) == []


def test_landmarks_are_points_of_source_and_target_whatever_the_direction(directions, batches):
    samples = [cloud.descriptors.samples for cloud in (directions.pair.source, directions.pair.target)]
    for candidate in batches[0] + batches[1]:
        if not candidate.by_paths:
            assert np.isin(candidate.landmarks[:, 0], samples[0]).all()
            assert np.isin(candidate.landmarks[:, 1], samples[1]).all()


@pytest.mark.parametrize(("sure", "number"), [(-1e9, 1), (1e9, 2)])
def test_more_sets_are_tried_only_where_the_first_do_not_do(batches, monkeypatch, sure, number):
    monkeypatch.setattr("medial.matching.fit_search.SURE", sure)
    found = match(figure(), bent_figure(*BENT), SMALL)
    assert len(found.restarts["cost"]) == sum(map(len, batches[:number]))


def test_the_table_of_restarts_says_which_direction():
    target = bent_figure(*BENT)
    both, one = match(figure(), target, SMALL), match(figure(), target, replace(SMALL, both_ways=False))
    assert both.restarts["backward"].any()
    assert not both.restarts["backward"].all()
    assert not one.restarts["backward"].any()
    back = both.restarts["backward"]
    for column in ("first", "partner"):  # every set is tried in both directions
        assert np.array_equal(both.restarts[column][back], both.restarts[column][~back])

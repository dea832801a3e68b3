"""The selection among the fits of a pair."""

from dataclasses import replace

import numpy as np
import pytest

from medial.matching.registration.evidence import WEIGHTS, log_likelihood
from medial.matching.registration.placement import ALIKE, place
from medial.matching.registration.selection import NEAR_BEST, VARIANTS, FineSelection, Rival, groups
from tests.medial.matching.registration.directions import SMALL, Directions, true_landmarks


@pytest.fixture(scope="module")
def directions():
    return Directions()


@pytest.fixture(scope="module")
def fits(directions):
    """The right fit of each direction, and one with an arm at the feet, not settled."""
    right = directions.best(directions.settled(true_landmarks()))
    return [*right, directions.all[0].follow([directions.astray])[0]]


def shifted(placement, shift, score):
    return replace(placement, places=placement.places + np.array([shift, 0, 0]), score=score)


def selected(fits, placements, config=SMALL):
    return FineSelection(fits, placements, config).finalists()


def test_the_most_likely_finalist_comes_first(fits):
    found = selected(fits, [place(fit) for fit in fits], replace(SMALL, finalists=3))
    values = [each.log_likelihood for each in found]
    assert values == sorted(values, reverse=True)
    assert found[0].number in (0, 1)
    for each in found:
        placed, fit, weights = place(fits[each.number]), each.fit, fits[0].weights
        expected = log_likelihood(weights, placed.score, fit.strain, each.medial_gap, fit.missed)
        assert each.log_likelihood == expected


def test_strain_of_the_finely_settled_fit_decides_between_equal_scores(fits, monkeypatch):
    """Two fits of one score; the second strains more once it is settled finely."""
    both = [fits[0], fits[0]]
    at = place(fits[0])
    placements = [shifted(at, 0.0, 1.5), shifted(at, 3 * ALIKE, 1.5)]
    settled = FineSelection._finalist

    def strained(self, k):
        found = settled(self, k)
        return replace(found, log_likelihood=found.log_likelihood - (5.0 if k == 0 else 0.0))

    monkeypatch.setattr(FineSelection, "_finalist", strained)
    assert [each.number for each in selected(both, placements)] == [1, 0]


def test_fits_that_are_far_from_the_best_score_are_not_settled(fits):
    at = place(fits[0])
    placements = [
        shifted(at, 3 * ALIKE * k, 1.5 - 0.6 * NEAR_BEST / WEIGHTS.quick_score * k) for k in range(3)
    ]
    found = selected([fits[0]] * 3, placements, replace(SMALL, finalists=3))
    assert sorted(each.number for each in found) == [0, 1]


def test_of_equal_scores_those_whose_medial_balls_meet_are_settled(fits):
    at = place(fits[0])
    placements = [shifted(at, 3 * ALIKE * k, 1.5) for k in range(4)]
    apart = [replace(fits[0]) for _ in range(4)]
    for k, each in enumerate(apart):
        vars(each)["medial_gap"] = 0.05 * (3 - k)  # as if measured
    found = selected(apart, placements, replace(SMALL, finalists=2))
    assert sorted(each.number for each in found) == [2, 3]


def test_of_like_fits_the_best_is_compared_as_a_whole_map_and_some_as_variants(fits):
    at, many = place(fits[0]), VARIANTS + 4
    placements = [shifted(at, 0.01 * ALIKE * k, 1.5 - 0.001 * k) for k in range(many)]
    found = selected([fits[0]] * many, placements)
    assert sorted(each.number for each in found) == list(range(1 + VARIANTS))


@pytest.mark.parametrize(("apart", "batches"), [(0.01, 1), (3, 2)], ids=["one whole map", "several"])
def test_variants_settle_beside_the_only_whole_map(fits, monkeypatch, apart, batches):
    """Where one map is left, which one is the best is known before it is settled."""
    at, many = place(fits[0]), 3
    placements = [shifted(at, apart * ALIKE * k, 1.5 - 0.001 * k) for k in range(many)]
    settled, calls = FineSelection._settled, []
    monkeypatch.setattr(FineSelection, "_settled", lambda self, k: calls.append(k) or settled(self, k))
    found = selected([fits[0]] * many, placements, replace(SMALL, finalists=3))
    assert sorted(each.number for each in found) == list(range(many))
    assert len(calls) == batches


def test_without_deformation_fits_are_carried_over_but_not_settled(fits):
    placements = [place(fit) for fit in fits]
    quick = selected(fits, placements, replace(SMALL, refine="spectral"))
    settled = selected(fits, placements)
    assert {e.number for e in quick} >= {settled[0].number}
    assert quick[0].fit.seen < settled[0].fit.seen


@pytest.mark.parametrize("direction", [0, 1])
def test_either_direction_gives_the_map_of_the_source(directions, fits, direction):
    placements = [place(fit) for fit in fits]
    placements[direction] = replace(placements[direction], score=9.0)
    selection = FineSelection(fits, placements, SMALL)
    best = selection.finalists()[0]
    assert best.number == direction
    dense = selection.dense(best)
    source, target = directions.pair.source.cloud, directions.pair.target.cloud
    assert len(dense.match) == len(source)
    truth = target.points[np.arange(len(source))]  # target points have the source's order
    assert np.linalg.norm(target.points[dense.match] - truth, axis=1).mean() < 0.05


def test_like_finalists_are_one_group_and_groups_share_the_probability(fits):
    at = place(fits[0])
    shifts = (0.0, 0.2 * ALIKE, 5 * ALIKE)
    placements = [shifted(at, shift, 1.0) for shift in shifts]
    values = (22.0, 21.5, 21.0)
    rivals = [Rival(k, value) for k, value in enumerate(values)]
    (first, likely), (second, less) = groups(rivals, -100.0, placements)
    assert (first.number, second.number) == (0, 2)
    assert likely + less == pytest.approx(1)
    assert likely / less == pytest.approx(np.e)


def test_fits_that_were_not_settled_finely_are_rivals_by_their_score(fits):
    at = place(fits[0])
    scores = (1.5, 1.4, 1.3, 1.3)
    shifts = (0.0, 3 * ALIKE, 6 * ALIKE, 6.1 * ALIKE)  # the last is the one before it
    placements = [shifted(at, shift, score) for shift, score in zip(shifts, scores, strict=True)]
    selection = FineSelection([fits[0]] * 4, placements, replace(SMALL, finalists=1))
    (best,) = selection.finalists()
    rivals = selection.rivals([best])
    lossy = replace(best, number=1, log_likelihood=best.log_likelihood - 3.0)
    assert selection.rivals([best, best, lossy, lossy, lossy])[-1].log_likelihood < rivals[-1].log_likelihood
    assert [each.number for each in rivals] == [0, 1, 2]
    losses = [best.log_likelihood - each.log_likelihood for each in rivals]
    assert losses == pytest.approx([0.0, 0.1 * WEIGHTS.quick_score, 0.2 * WEIGHTS.quick_score])

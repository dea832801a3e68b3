"""Parts of settled maps are exchanged; like maps are one."""

from dataclasses import replace

import numpy as np
import pytest

from medial.matching.registration.exchange import SAME_FIT, ExchangeLimits, distinct, exchange_parts
from medial.matching.registration.registration import Schedule
from tests.medial.posed import Setup, bent_figure, error, left_arm, legs, mapped, right_arm

BENT = (1.0, 0.8)


@pytest.fixture(scope="module")
def setup():
    return Setup(bent_figure(*BENT))


@pytest.fixture(scope="module")
def fits(setup):
    """Settled maps that are right but for some limbs."""
    points = setup.points * setup.unit
    wrong = {
        "nothing": np.zeros(len(points), dtype=bool),
        "right arm": right_arm(points),
        "left arm": left_arm(points),
        "legs": legs(points),
    }
    schedule = Schedule()
    return {
        name: setup.registration.settle(
            setup.registration.follow(*mapped(setup, among, *BENT), schedule), schedule
        )
        for name, among in wrong.items()
    }


@pytest.mark.parametrize(
    ("first", "second"), [("right arm", "left arm"), ("right arm", "legs"), ("legs", "left arm")]
)
def test_two_maps_with_different_limbs_wrong_make_a_right_one(setup, fits, first, second):
    parents = [fits[first], fits[second]]
    pool = exchange_parts(setup.registration, parents, ExchangeLimits())
    assert min(error(setup, parent, *BENT).mean() for parent in parents) > 0.03
    assert error(setup, pool[0], *BENT).mean() < 0.01
    assert pool[0].score > max(parent.score for parent in parents) + 0.1
    assert pool[0].score == pytest.approx(fits["nothing"].score, abs=0.01)


def test_the_pool_is_distinct_and_sorted(setup, fits):
    pool = exchange_parts(setup.registration, list(fits.values()), ExchangeLimits(donors=3))
    scores = [fit.score for fit in pool]
    assert 1 < len(pool) <= 3
    assert scores == sorted(scores, reverse=True)
    assert scores[0] >= fits["nothing"].score
    for k, fit in enumerate(pool):
        for other in pool[:k]:
            assert np.linalg.norm(fit.moved - other.moved, axis=1).mean() > SAME_FIT


def test_parents_are_left_as_they_are(setup, fits):
    parents = [fits["right arm"], fits["legs"]]
    before = [parent.pose.positions.copy() for parent in parents]
    exchange_parts(setup.registration, parents, ExchangeLimits(rounds=1))
    for parent, positions in zip(parents, before, strict=True):
        assert np.array_equal(parent.pose.positions, positions)


def test_nothing_is_exchanged_without_rounds_or_rivals(setup, fits):
    wrong = [fits["right arm"], fits["legs"]]
    unchanged = exchange_parts(setup.registration, wrong, ExchangeLimits(rounds=0))
    assert {id(fit) for fit in unchanged} == {id(fit) for fit in wrong}
    alone = exchange_parts(setup.registration, [fits["legs"]], ExchangeLimits())
    assert len(alone) == 1
    assert alone[0] is fits["legs"]


def shifted(fit, gap, strain):
    return replace(fit, moved=fit.moved + np.array([gap, 0, 0]), strain=strain)


def test_of_like_fits_the_best_stays(fits):
    base = fits["nothing"]
    worse, best, other = shifted(base, 0, 4e-3), shifted(base, 0.05, 1e-3), shifted(base, 0.5, 2e-3)
    kept = distinct([worse, other, best], 10)
    assert [id(fit) for fit in kept] == [id(best), id(other)]


def test_fits_further_apart_than_the_limit_are_two(fits):
    base = shifted(fits["nothing"], 0, 1e-3)
    for gap, count in ((0.95 * SAME_FIT, 1), (1.05 * SAME_FIT, 2)):
        assert len(distinct([base, shifted(base, gap, 2e-3)], 10)) == count


def test_at_most_so_many_distinct_fits(fits):
    many = [shifted(fits["nothing"], k, 1e-3 * k) for k in (3, 1, 4, 2)]
    kept = distinct(many, 2)
    assert [id(fit) for fit in kept] == [id(many[1]), id(many[3])]
    assert distinct([], 3) == []

"""The selection among the fits of a pair."""

from dataclasses import replace

import numpy as np
import pytest

from medial.matching.registration.placement import ALIKE, place
from medial.matching.registration.selection import LEVEL, FineSelection
from tests.medial.matching.registration.directions import SMALL, Directions, true_landmarks


@pytest.fixture(scope="module")
def directions():
    return Directions()


@pytest.fixture(scope="module")
def fits(directions):
    """Of each direction one fit, twice: as far as settling tells, they are equally good."""
    return [fit for fit in directions.best(directions.settled(true_landmarks())) for _ in range(2)]


def chosen(fits, shift, loss, config=SMALL):
    """The choice between a fit and one of more merit that is `shift` away and scores less by `loss`."""
    first = replace(place(fits[0]), score=1.5, merit=1.0)
    other = replace(first, places=first.places + np.array([shift, 0, 0]), score=1.5 - loss, merit=1.4)
    return FineSelection(fits[:2], [first, other], config).choose()[0]


@pytest.mark.parametrize(
    ("shift", "loss", "best"),
    [
        (0.3 * ALIKE, 0.5 * LEVEL, 1),  # a limb apart: paths count
        (3.0 * ALIKE, 0.5 * LEVEL, 0),  # another map: the score decides
        (0.3 * ALIKE, 1.5 * LEVEL, 0),  # a limb apart, but fits worse
    ],
)
def test_paths_choose_between_like_fits_alone(fits, shift, loss, best):
    assert chosen(fits, shift, loss) == best


def test_between_like_fits_the_finely_settled_score_counts_as_well(fits, monkeypatch):
    """Settled finely, the fit of more merit holds together so badly that its paths do not make up for it."""
    settle, held = FineSelection._settled_finely, (1.0, 0.4)
    monkeypatch.setattr(
        FineSelection, "_settled_finely", lambda self, k: replace(settle(self, k), held=held[k])
    )
    assert chosen(fits, 0.3 * ALIKE, 0.5 * LEVEL) == 0


def test_a_map_that_meets_less_of_the_surfaces_is_not_taken_for_its_paths(fits, monkeypatch):
    """Settled finely, the fit of more merit sees less of both clouds than the other one."""
    settle = FineSelection._settled_finely

    def less(self, k):
        found, share = settle(self, k), (1.0, 0.9)[k]
        missed = found.missed + (1 - share) * found.seen
        return replace(found, found=share * found.found, found_back=share * found.found_back, missed=missed)

    monkeypatch.setattr(FineSelection, "_settled_finely", less)
    assert chosen(fits, 0.3 * ALIKE, 0.5 * LEVEL) == 0


def test_without_deformation_the_score_decides(fits):
    assert chosen(fits, 0.3 * ALIKE, 0.5 * LEVEL, replace(SMALL, refine="spectral")) == 0


@pytest.mark.parametrize("direction", [0, 1])
def test_either_direction_gives_the_map_of_the_source(directions, fits, direction):
    placements = [place(fit) for fit in fits]
    placements[2 * direction] = replace(placements[2 * direction], score=9.0)
    best, dense = FineSelection(fits, placements, SMALL).choose()
    assert best == 2 * direction
    source, target = directions.pair.source.cloud, directions.pair.target.cloud
    assert len(dense.match) == len(source)
    truth = target.points[np.arange(len(source))]  # target points have the source's order
    assert np.linalg.norm(target.points[dense.match] - truth, axis=1).mean() < 0.05

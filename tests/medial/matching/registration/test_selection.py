"""The last choice among the fits of a pair."""

from dataclasses import replace

import numpy as np
import pytest

from medial.matching.match import Pair
from medial.matching.registration.direction import ALIKE
from medial.matching.registration.selection import LEVEL, Finish
from tests.medial.matching.test_default_match import BENT, SMALL
from tests.medial.posed import bent_figure, figure


@pytest.fixture(scope="module")
def pair():
    return Pair(figure(), bent_figure(*BENT), SMALL, 0)


@pytest.fixture(scope="module")
def pools(pair):
    """Of each way one fit, twice: as far as settling tells, they are equally good."""
    landmarks = np.repeat(np.linspace(0, len(figure()) - 1, 7).astype(np.int64)[:, None], 2, axis=1)
    candidates = pair.given(landmarks)
    return [2 * w.settle(w.follow(c))[:1] for w, c in zip(pair.ways, candidates, strict=True)]


def chosen(pair, pools, shift, loss, config=SMALL):
    """The choice between a fit and one of more merit that is `shift` away and scores less by `loss`."""
    way, pool = pair.ways[0], pools[0]
    first = replace(way.placed(pool[0]), score=1.5, merit=1.0)
    other = replace(first, places=first.places + np.array([shift, 0, 0]), score=1.5 - loss, merit=1.4)
    return Finish([way], [pool], [first, other], config).chosen()[0]


@pytest.mark.parametrize(
    ("shift", "loss", "best"),
    [
        (0.3 * ALIKE, 0.5 * LEVEL, 1),  # a limb apart: paths count
        (3.0 * ALIKE, 0.5 * LEVEL, 0),  # another map: the score decides
        (0.3 * ALIKE, 1.5 * LEVEL, 0),  # a limb apart, but fits worse
    ],
)
def test_paths_choose_between_like_fits_alone(pair, pools, shift, loss, best):
    assert chosen(pair, pools, shift, loss) == best


def test_between_like_fits_the_finely_settled_score_counts_as_well(pair, pools, monkeypatch):
    """Settled finely, the fit of more merit holds together so badly that its paths do not make up for it."""
    settle, held = Finish._settled_finely, (1.0, 0.4)
    monkeypatch.setattr(Finish, "_settled_finely", lambda self, k: replace(settle(self, k), held=held[k]))
    assert chosen(pair, pools, 0.3 * ALIKE, 0.5 * LEVEL) == 0


def test_a_map_that_meets_less_of_the_surfaces_is_not_taken_for_its_paths(pair, pools, monkeypatch):
    """Settled finely, the fit of more merit sees less of both clouds than the other one."""
    settle = Finish._settled_finely

    def less(self, k):
        found, share = settle(self, k), (1.0, 0.9)[k]
        return replace(found, found=share * found.found, found_back=share * found.found_back)

    monkeypatch.setattr(Finish, "_settled_finely", less)
    assert chosen(pair, pools, 0.3 * ALIKE, 0.5 * LEVEL) == 0


def test_without_deformation_the_score_decides(pair, pools):
    assert chosen(pair, pools, 0.3 * ALIKE, 0.5 * LEVEL, replace(SMALL, refine="spectral")) == 0


@pytest.mark.parametrize("way", [0, 1])
def test_either_way_gives_the_map_of_the_source(pair, pools, way):
    placed = [w.placed(fit) for w, pool in zip(pair.ways, pools, strict=True) for fit in pool]
    placed[2 * way] = replace(placed[2 * way], score=9.0)
    best, dense = Finish(pair.ways, pools, placed, SMALL).chosen()
    assert best == 2 * way
    source, target = (end.cloud for end in pair.ends)
    assert len(dense.match) == len(source)
    truth = target.points[np.arange(len(source))]  # target points have the source's order
    assert np.linalg.norm(target.points[dense.match] - truth, axis=1).mean() < 0.05

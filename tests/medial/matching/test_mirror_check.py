"""What is said about mirrored maps."""

import numpy as np
import pytest

from medial.matching.common_units import CloudInUnits
from medial.matching.landmarks.candidates import Candidate
from medial.matching.mirror_check import LIKELY, RIVAL, mirror_verdict
from medial.matching.registration.placement import Placement

POINTS = np.random.default_rng(0).standard_normal((50, 3))
MIRRORED = POINTS * [-1, 1, 1]
TARGET = CloudInUnits(
    np.concatenate([POINTS, MIRRORED]), np.tile([0.0, 0, 1], (100, 1)), np.zeros((100, 3)), np.zeros(100)
)
SAME, MIRROR = np.arange(50), np.arange(50, 100)


def candidate(at_samples, cost, by_paths=False):
    return Candidate(np.zeros((1, 2), dtype=int), cost, by_paths, at_samples, lambda: at_samples)


BEST = Placement(POINTS, 1.5)


@pytest.mark.parametrize(("costs", "verdict"), [((1.0, 2.0), "agrees"), ((2.0, 1.0), "overruled")])
def test_the_fit_agrees_with_the_map_of_the_lowest_cost_or_overrules_it(costs, verdict):
    candidates = [candidate(SAME, costs[0]), candidate(MIRROR, costs[1])]
    assert mirror_verdict(BEST, [], 0.0, candidates, TARGET) == verdict


def test_sets_found_by_path_length_have_no_say():
    candidates = [candidate(MIRROR, float("nan"), by_paths=True), candidate(SAME, 5.0)]
    assert mirror_verdict(BEST, [], 0.0, candidates, TARGET) == "agrees"


def test_without_a_set_of_eq_16_nothing_is_checked():
    assert (
        mirror_verdict(BEST, [], 0.0, [candidate(MIRROR, float("nan"), by_paths=True)], TARGET) == "unchecked"
    )


def test_many_rivals_leave_it_open_together():
    rivals = [(Placement(POINTS + np.array([3.0 + k, 0, 0]), 1.0), 0.1) for k in range(4)]
    assert mirror_verdict(BEST, rivals, 0.0, [candidate(SAME, 1.0)], TARGET) == "undecided"


@pytest.mark.parametrize(
    ("probability", "shift", "verdict"),
    [
        (1.2 * LIKELY, 3.0, "undecided"),
        (0.8 * LIKELY, 3.0, "agrees"),
        (1.2 * LIKELY, 0.5 * RIVAL, "agrees"),  # no rival, but the same map
    ],
)
def test_a_rival_that_is_as_likely_leaves_it_open(probability, shift, verdict):
    rival = Placement(POINTS + np.array([shift, 0, 0]), BEST.score)
    assert mirror_verdict(BEST, [(rival, probability)], 0.0, [candidate(SAME, 1.0)], TARGET) == verdict


def test_where_no_map_fits_nothing_is_decided():
    assert mirror_verdict(BEST, [], 0.9, [candidate(SAME, 1.0)], TARGET) == "undecided"

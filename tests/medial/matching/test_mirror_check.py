"""What is said about mirrored maps."""

import numpy as np
import pytest

from medial.matching.common_units import Cloud
from medial.matching.landmarks.candidates import Candidate
from medial.matching.mirror_check import MARGIN, RIVAL, flip_verdict
from medial.matching.registration.direction import Placed

POINTS = np.random.default_rng(0).standard_normal((50, 3))
MIRRORED = POINTS * [-1, 1, 1]
TARGET = Cloud(
    np.concatenate([POINTS, MIRRORED]), np.tile([0.0, 0, 1], (100, 1)), np.zeros((100, 3)), np.zeros(100)
)
SAME, FLIPPED = np.arange(50), np.arange(50, 100)


def candidate(at_samples, cost, by_paths=False):
    return Candidate(np.zeros((1, 2), dtype=int), cost, by_paths, at_samples, lambda: at_samples)


BEST = Placed(POINTS, 1.5, 1.4)


@pytest.mark.parametrize(("costs", "verdict"), [((1.0, 2.0), "kept"), ((2.0, 1.0), "flipped")])
def test_the_map_of_the_lowest_cost_is_kept_or_flipped(costs, verdict):
    candidates = [candidate(SAME, costs[0]), candidate(FLIPPED, costs[1])]
    assert flip_verdict(BEST, [BEST], candidates, TARGET) == verdict


def test_sets_found_by_path_length_have_no_say():
    candidates = [candidate(FLIPPED, float("nan"), by_paths=True), candidate(SAME, 5.0)]
    assert flip_verdict(BEST, [BEST], candidates, TARGET) == "kept"


@pytest.mark.parametrize(
    ("loss", "shift", "verdict"),
    [
        (0.5 * MARGIN, 3.0, "undecided"),
        (2.0 * MARGIN, 3.0, "kept"),
        (0.5 * MARGIN, 0.5 * RIVAL, "kept"),  # no rival, but the same map
    ],
)
def test_a_rival_that_fits_as_well_leaves_it_open(loss, shift, verdict):
    rival = Placed(POINTS + np.array([shift, 0, 0]), BEST.score - loss, BEST.merit)
    assert flip_verdict(BEST, [BEST, rival], [candidate(SAME, 1.0)], TARGET) == verdict

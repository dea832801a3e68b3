"""The figure and its bent copy, prepared for matching in both directions."""

from dataclasses import replace

import numpy as np

from medial import MatchConfig
from medial.matching.candidate_batches import candidates
from medial.matching.prepared import prepare_pair
from medial.matching.registration.direction import pair_directions
from medial.matching.registration.search import follow, of, settle
from tests.medial.posed import bent_figure, figure, legs, right_arm

SMALL = MatchConfig(samples=150, times=10, restarts=4, nodes=40, fine_nodes=80, finalists=2)
BENT = (0.9, -0.7)


class Directions:
    """The prepared pair and its directions, for some settings."""

    def __init__(self, **settings):
        self.pair = prepare_pair(figure(), bent_figure(*BENT), replace(SMALL, **settings), 0)
        self.all = pair_directions(self.pair)

    def given(self, landmarks):
        """The candidate that given landmarks make, for each direction."""
        return [c for each in self.all for c in candidates(each, [landmarks], [])]

    def settled(self, landmarks):
        """What it settles to, for each direction."""
        return settle(self.all, follow(self.all, self.given(landmarks)))

    def best(self, fits):
        """The first fit of each direction."""
        return [of(each, fits)[0] for each in self.all]

    @property
    def true_places(self):
        """Where the samples go: target points have the source's order."""
        return self.pair.target.cloud.points[self.pair.source.descriptors.samples]

    @property
    def astray(self):
        """A candidate of the source that is right but for an arm, which goes to the feet."""
        goal = self.pair.source.descriptors.samples.copy()
        goal[right_arm(figure().points[goal])] = np.flatnonzero(legs(figure().points))[0]
        return replace(self.given(np.array([[0, 0]]))[0], at_samples=goal)


def true_landmarks():
    return np.repeat(np.linspace(0, len(figure()) - 1, 7).astype(np.int64)[:, None], 2, axis=1)

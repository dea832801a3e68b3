"""The selection among the fits of a pair.

The score decides how the body as a whole goes onto the other one. Among maps that differ by a limb, path
lengths along the body count as well.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import run_tasks
from medial.matching.config import MatchConfig
from medial.matching.registration.direction import DirectedFit, Direction
from medial.matching.registration.fit import Fit
from medial.matching.registration.placement import MARGIN, Placement
from medial.matching.registration.refinement import DenseFit, FineDeformation

Float = NDArray[np.float64]

NEAR_BEST = 0.25
"""Fits whose score is within this of the best are judged with fine nodes."""
JUDGED_FINELY = 8
"""At most so many of them."""
FINALIST = 0.2
"""Of those, fits that are worth less than the best by more than this are not settled finely."""
SETTLED = 0.5
"""Worth of what a fit sees once it is settled finely, added to its score or merit. Between bodies that lie
differently, what settling finely adds to the strain is noise."""
LEVEL = 2 * MARGIN
"""Maps a limb apart whose score is within this of the best are level."""


class FineSelection:
    """Good fits judged with fine nodes, and the best of them.

    Parameters
    ----------
    fits
    placements
        Of the same fits.
    config
    """

    def __init__(self, fits: list[DirectedFit], placements: list[Placement], config: MatchConfig) -> None:
        self._fits, self._placements, self._config = fits, placements, config
        self._fine: dict[Direction, FineDeformation] = {}
        self._judged: dict[int, Fit] = {}
        self._settled: dict[int, Fit] = {}

    def choose(self) -> tuple[int, DenseFit]:
        """Position of the best fit in the list, and the map of all source points that it makes.

        What the fits score and see decides which body goes where. Of maps that are like the best one and
        nearly as good, the score of the finely settled fit and paths along the body decide. Paths alone do
        not: where scans have gaps, they change under the right map as much as from head to tail.
        """
        scores = np.array([each.score for each in self._placements])
        if self._config.refine != "deform":
            best = int(scores.argmax())
            self._judge([best], self._config.nodes)
            return best, self._dense(best, self._judged[best])
        leader = self._best(scores)
        like = np.array([each.like(self._placements[leader]) for each in self._placements])
        merits = np.array([each.merit for each in self._placements])
        near = self._finalists(np.where(like & (scores > scores[leader] - LEVEL), merits, -np.inf))
        worth = {k: scores[k] + SETTLED * self._settled[k].agreement for k in (leader, *near)}
        level = [k for k in worth if worth[k] > worth[leader] - LEVEL]
        best = max(level, key=lambda k: merits[k] + self._settled[k].score - self._fits[k].score)
        return best, self._dense(best, self._settled[best])

    def _best(self, values: Float) -> int:
        """The fit of the highest value after those of high value were settled finely."""
        return max(self._finalists(values), key=lambda k: values[k] + SETTLED * self._settled[k].agreement)

    def _finalists(self, values: Float) -> list[int]:
        """Fits of high value, settled finely; best first by what they were worth before that."""
        near = np.argsort(-values, kind="stable")[:JUDGED_FINELY]
        near = near[values[near] > values.max() - NEAR_BEST]
        self._judge(near, self._config.fine_nodes)
        worth = values[near] + [SETTLED * self._judged[k].agreement for k in near]
        order = np.argsort(-worth, kind="stable")[: self._config.finalists]
        final = [int(k) for k in near[order[worth[order] > worth.max() - FINALIST]]]
        self._settle(final)
        return final

    def _judge(self, numbers: Iterable[int], nodes: int) -> None:
        """Carry fits over to fine nodes and judge them there."""
        new = [k for k in numbers if k not in self._judged]
        directions = [d for d in dict.fromkeys(self._fits[k].direction for k in new) if d not in self._fine]
        fine = run_tasks(Direction.fine, [(each, nodes) for each in directions])
        self._fine |= dict(zip(directions, fine, strict=True))
        self._judged |= dict(zip(new, run_tasks(self._judged_finely, [(k,) for k in new]), strict=True))

    def _judged_finely(self, k: int) -> Fit:
        fit = self._fits[k]
        fine, direction = self._fine[fit.direction], fit.direction
        return fine.judge(fine.adopt(direction.graph, direction.attachment, fit.pose))

    def _settle(self, numbers: Iterable[int]) -> None:
        new = [k for k in numbers if k not in self._settled]
        self._settled |= dict(zip(new, run_tasks(self._settled_finely, [(k,) for k in new]), strict=True))

    def _settled_finely(self, k: int) -> Fit:
        return self._fine[self._fits[k].direction].settle(self._judged[k].pose)

    def _dense(self, k: int, fit: Fit) -> DenseFit:
        """The map from the pair's source to its target."""
        fine = self._fine[self._fits[k].direction]
        return fine.inverse(fit) if self._fits[k].backward else fine.dense(fit)

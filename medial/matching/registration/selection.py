"""The last choice among the fits of a pair: which body goes where by fit, which limb goes where by paths."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import run_tasks
from medial.matching.config import MatchConfig
from medial.matching.mirror_check import MARGIN
from medial.matching.registration.direction import Placed, Way
from medial.matching.registration.refinement import Dense, FineDeformation
from medial.matching.registration.registration import Fit

Float = NDArray[np.float64]

ADOPTED = (0.25, 8)
"""Fits whose score is within this of the best are looked at with fine nodes, at most so many."""
FINALIST = 0.2
"""Of those, what is worth less than the best by more than this is not settled finely."""
SETTLED = 0.5
"""Worth of what a fit sees once it is settled finely, added to its score or merit. Between bodies that lie
differently, what settling finely adds to the strain is noise."""
LEVEL = 2 * MARGIN
"""Maps a limb apart whose score is within this of the best are level."""


class Finish:
    """Good fits, looked at with fine nodes.

    Parameters
    ----------
    ways
    pools
        Fits of each way.
    placed
        The same fits one after the other, placed.
    config
    """

    def __init__(
        self, ways: list[Way], pools: list[list[Fit]], placed: list[Placed], config: MatchConfig
    ) -> None:
        self._fits = [(k, fit) for k, pool in enumerate(pools) for fit in pool]
        self._ways, self._placed, self._config = ways, placed, config
        self._fine: dict[int, FineDeformation] = {}
        self._looked: dict[int, Fit] = {}
        self._settled: dict[int, Fit] = {}

    def chosen(self) -> tuple[int, Dense]:
        """Number of the best fit, and the map of all source points that it makes.

        What the fits score and see decides which body goes where. Which limb goes where, of maps like the
        best one and nearly as good, do the score of the finely settled fit and paths along the body. Paths
        alone do not: where scans have gaps, they change under the right map as much as from head to tail.
        """
        scores = np.array([each.score for each in self._placed])
        if self._config.refine != "deform":
            best = int(scores.argmax())
            self._look([best], self._config.nodes)
            return best, self._dense(best, self._looked[best])
        leader = self._best(scores)
        like = np.array([each.like(self._placed[leader]) for each in self._placed])
        merits = np.array([each.merit for each in self._placed])
        near = self._near(np.where(like & (scores > scores[leader] - LEVEL), merits, -np.inf))
        worth = {k: scores[k] + SETTLED * self._settled[k].seen for k in (leader, *near)}
        level = [k for k in worth if worth[k] > worth[leader] - LEVEL]
        best = max(level, key=lambda k: merits[k] + self._settled[k].score - self._fits[k][1].score)
        return best, self._dense(best, self._settled[best])

    def _best(self, values: Float) -> int:
        """The fit of the highest value after those of high value were settled finely."""
        return max(self._near(values), key=lambda k: values[k] + SETTLED * self._settled[k].seen)

    def _near(self, values: Float) -> list[int]:
        """Fits of high value, settled finely, best first before that."""
        margin, most = ADOPTED
        near = np.argsort(-values, kind="stable")[:most]
        near = near[values[near] > values.max() - margin]
        self._look(near, self._config.fine_nodes)
        worth = values[near] + [SETTLED * self._looked[k].seen for k in near]
        order = np.argsort(-worth, kind="stable")[: self._config.finalists]
        final = [int(k) for k in near[order[worth[order] > worth.max() - FINALIST]]]
        self._settle(final)
        return final

    def _look(self, numbers: Iterable[int], nodes: int) -> None:
        new = [k for k in numbers if k not in self._looked]
        ways = sorted({self._fits[k][0] for k in new} - self._fine.keys())
        fine = run_tasks(lambda w: self._ways[w].fine(nodes), [(w,) for w in ways])
        self._fine |= dict(zip(ways, fine, strict=True))
        self._looked |= dict(zip(new, run_tasks(self._adopted, [(k,) for k in new]), strict=True))

    def _adopted(self, k: int) -> Fit:
        w, fit = self._fits[k]
        way, fine = self._ways[w], self._fine[w]
        return fine.judge(fine.adopt(way.graph, way.attachment, fit.pose))

    def _settle(self, numbers: Iterable[int]) -> None:
        new = [k for k in numbers if k not in self._settled]
        self._settled |= dict(zip(new, run_tasks(self._settled_finely, [(k,) for k in new]), strict=True))

    def _settled_finely(self, k: int) -> Fit:
        return self._fine[self._fits[k][0]].settle(self._looked[k].pose)

    def _dense(self, k: int, fit: Fit) -> Dense:
        w = self._fits[k][0]
        return self._fine[w].inverse(fit) if self._ways[w].backward else self._fine[w].dense(fit)

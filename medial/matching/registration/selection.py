"""The selection among the fits of a pair: the best ones are settled finely and compared by all evidence."""

from collections.abc import Iterable
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import run_tasks
from medial.matching.config import MatchConfig
from medial.matching.registration.direction import DirectedFit, Direction
from medial.matching.registration.evidence import log_likelihood, probabilities, promise
from medial.matching.registration.exchange import SAME_FIT
from medial.matching.registration.fit import Fit
from medial.matching.registration.placement import Placement
from medial.matching.registration.refinement import DenseFit, FineDeformation

Float = NDArray[np.float64]

NEAR_BEST = 7.0
"""Fits whose promise is within this of the best are settled finely."""
VARIANTS = 3
"""At most so many fits that differ from the best one in a limb alone are settled finely as well."""
VARIANT_NEAR = 1.7
"""Those whose promise is within this of the best."""


@dataclass(frozen=True)
class Rival:
    """A fit that is compared with others.

    Attributes
    ----------
    number : int
        Position in the list of fits.
    log_likelihood : float
        Of the map that it makes (`evidence.log_likelihood`); estimated if it was not settled finely.
    """

    number: int
    log_likelihood: float


@dataclass(frozen=True)
class Finalist(Rival):
    """A fit that was settled finely.

    Attributes
    ----------
    fit : Fit
        Settled finely.
    medial_gap : float
        Of that fit (`evidence.medial_gap`).
    """

    fit: Fit
    medial_gap: float


class FineSelection:
    """Good fits settled finely, and which of them is the most likely one.

    Parameters
    ----------
    fits
    placements
        Of the same fits.
    config
    """

    def __init__(self, fits: list[DirectedFit], placements: list[Placement], config: MatchConfig) -> None:
        self._fits, self._placements, self._config = fits, placements, config
        self._weights = fits[0].weights
        gaps = run_tasks(attrgetter("medial_gap"), [(each,) for each in fits])
        self._promise = [
            promise(self._weights, p.score, gap) for p, gap in zip(placements, gaps, strict=True)
        ]
        self._order = sorted(range(len(placements)), key=lambda k: -self._promise[k])
        self._nodes = config.fine_nodes if config.refine == "deform" else config.nodes
        self._fine: dict[Direction, FineDeformation] = {}

    def finalists(self) -> list[Finalist]:
        """Whole maps, and those that differ from the best of these in a limb; the most likely one first.

        Without deformation (`MatchConfig.refine`) fits are carried over to the nodes, but not settled.
        """
        whole = self._whole_maps()
        if len(whole) == 1:  # the best one is known before it is settled: all settle side by side
            return _ranked(self._settled(whole + self._variants(whole[0], set(whole))))
        found = _ranked(self._settled(whole))
        variants = self._variants(found[0].number, {each.number for each in found})
        return _ranked(found + self._settled(variants))

    def rivals(self, finalists: list[Finalist]) -> list[Rival]:
        """The finalists, and the fits that were not settled finely and differ from them and from each other.

        Settled finely, these are taken to lose what the finalists lose (median); they count as no more likely
        than the best.

        Parameters
        ----------
        finalists
            The most likely one first.
        """
        rivals = list[Rival](finalists)
        loss = float(np.median([self._promise[f.number] - f.log_likelihood for f in finalists]))
        for k in self._order:
            each = self._placements[k]
            if all(each.gap(self._placements[other.number]) > SAME_FIT for other in rivals):
                rivals.append(Rival(k, min(finalists[0].log_likelihood, self._promise[k] - loss)))
        return rivals

    def dense(self, finalist: Finalist) -> DenseFit:
        """The map from the pair's source to its target."""
        fit = self._fits[finalist.number]
        fine = self._fine[fit.direction]
        return fine.inverse(finalist.fit) if fit.backward else fine.dense(finalist.fit)

    def _whole_maps(self) -> list[int]:
        """Fits of nearly the best promise that differ from each other as a whole, best first."""
        highest = self._promise[self._order[0]]
        kept: list[int] = []
        for k in self._order:
            if self._promise[k] < highest - NEAR_BEST or len(kept) == self._config.finalists:
                break
            if all(self._placements[k].gap(self._placements[other]) > SAME_FIT for other in kept):
                kept.append(k)
        return kept

    def _variants(self, best: int, settled: set[int]) -> list[int]:
        """Other fits that are like the best one and promise nearly as much; best first."""
        leader, least = self._placements[best], self._promise[best] - VARIANT_NEAR
        near = [
            k
            for k in self._order
            if k not in settled and self._placements[k].like(leader) and self._promise[k] > least
        ]
        return near[:VARIANTS]

    def _settled(self, numbers: list[int]) -> list[Finalist]:
        """Carry fits over to fine nodes and settle them there."""
        directions = dict.fromkeys(self._fits[k].direction for k in numbers)
        missing = [each for each in directions if each not in self._fine]
        fine = run_tasks(Direction.fine, [(each, self._nodes) for each in missing])
        self._fine |= dict(zip(missing, fine, strict=True))
        return run_tasks(self._finalist, [(k,) for k in numbers])

    def _finalist(self, k: int) -> Finalist:
        quick, placed = self._fits[k], self._placements[k]
        fine, direction = self._fine[quick.direction], quick.direction
        pose = fine.adopt(direction.graph, direction.attachment, quick.pose)
        fit = fine.settle(pose) if self._config.refine == "deform" else fine.judge(pose)
        gap = fine.medial_gap(fit)
        likelihood = log_likelihood(self._weights, placed.score, fit.strain, gap, fit.missed)
        return Finalist(k, likelihood, fit, gap)


def groups(rivals: list[Rival], none: float, placements: list[Placement]) -> list[tuple[Rival, float]]:
    """The first rival of each group of like ones (`Placement.like`), and its group's probability.

    Parameters
    ----------
    rivals
        Each group's most likely one before the others.
    none
        Log-likelihood of none being right.
    placements
        Of all fits.
    """
    heads: list[Rival] = []
    for each in rivals:
        if not any(placements[each.number].like(placements[head.number]) for head in heads):
            heads.append(each)
    share = probabilities(np.array([head.log_likelihood for head in heads]), none)
    return list(zip(heads, share.tolist(), strict=True))


def _ranked(finalists: Iterable[Finalist]) -> list[Finalist]:
    return sorted(finalists, key=lambda each: (-each.log_likelihood, each.number))

"""Dense correspondences between two clouds from their diffusions (Sec. 4, and what holds with data missing).

With `MatchConfig.paper()` this is Sec. 4 as written. By default

1. many landmark sets are grown, each with its alternatives (left for right, arm for leg),
2. each is tried out: the source is deformed along its map and settles on the target,
3. parts are exchanged between the settled maps (one may have the arms right and another the legs),
4. the best are deformed finely; the target point nearest to a deformed source point is its match.
"""

import logging
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from medial.cloud import Cloud, common_units
from medial.compiled import run_tasks
from medial.confidence import confidence_of_fit, confidence_of_residual
from medial.diffusion import Diffusion
from medial.flips import flip_verdict
from medial.landmarks import Side, extend, prepare, shared_times
from medial.matching_deform import Attachment, NodeGraph
from medial.matching_pool import Candidate, diffusion_candidates, grown, path_candidates
from medial.matching_recombine import Exchange, distinct, recombine
from medial.matching_register import Fit, Registration, Schedule
from medial.matching_types import MatchConfig, Matching
from medial.nearest import single_blas_thread
from medial.refine import FineDeformation, neighbourhoods, spectral_refinement

log = logging.getLogger(__name__)

QUICK = Schedule()
EARLY = 5
"""Rounds of closest points before like fits are merged and the worst are dropped."""
PROMISING = 20
"""Distinct fits that are settled to the end."""
ADOPTED = (0.25, 8)
"""Fits whose score is within this of the best are looked at with fine nodes, at most so many."""
FINALIST = 0.2
"""Of those, what is worth less than the best by more than this is not settled finely."""
COARSE_COST, FINE_COST = 350.0, 1000.0
"""Cost of the mean square strain of a quick fit, and of its pose carried over to fine nodes. What settling
finely adds to the strain is noise."""


def match(source: Diffusion, target: Diffusion, config: MatchConfig | None = None, seed: int = 0) -> Matching:
    """Match every source point to a target point.

    Parameters
    ----------
    source, target
        Diffusions of one kind of operator.
    config
        Defaults to `MatchConfig()`.
    seed
        Draws the samples, and the first landmarks where they are random. The same seed gives the same
        result for any number of threads.

    Returns
    -------
    Matching

    Raises
    ------
    InputError
        If the operators differ, or a cloud has no positive eigenvalue.
    """
    config = config or MatchConfig()
    with single_blas_thread():
        pair = Pair(source, target, config, seed)
        candidates = diffusion_candidates(
            pair.here, pair.there, pair.times, config, np.random.default_rng([seed, 2])
        )
        if config.paths and config.selection == "fit":
            candidates += path_candidates(pair.here, pair.source, pair.target)
        return pair.by_cost(candidates) if config.selection == "cost" else pair.by_fit(candidates)


def extrapolate(
    source: Diffusion,
    target: Diffusion,
    landmarks: NDArray[np.integer],
    config: MatchConfig | None = None,
    seed: int = 0,
) -> Matching:
    """Grow a dense correspondence from given landmarks (Eq. 17), and refine it as configured.

    Parameters
    ----------
    source, target
    landmarks : (L, 2)
        Source and target point ids.
    config, seed
        As for `match`; there is nothing to select.

    Raises
    ------
    InputError
        If a landmark is not a point of its cloud.
    """
    config = config or MatchConfig()
    pairs = np.asarray(landmarks, dtype=np.int64).reshape(-1, 2)
    for column, diffusion, name in ((0, source, "source"), (1, target, "target")):
        if len(pairs) == 0 or pairs[:, column].min() < 0 or pairs[:, column].max() >= len(diffusion):
            raise InputError(
                f"landmarks need {name} point ids in [0, {len(diffusion)}), got {pairs[:, column].tolist()}"
            )
    with single_blas_thread():
        pair = Pair(source, target, config, seed)
        candidates = [grown(pair.here, pair.there, pairs, config)]
        found = pair.by_cost(candidates) if config.selection == "cost" else pair.by_fit(candidates)
    return replace(found, landmarks=pairs)


class Pair:
    """Two clouds prepared for matching.

    Raises
    ------
    InputError
        If the operators differ: their diffusions cannot be compared.
    """

    def __init__(self, source: Diffusion, target: Diffusion, config: MatchConfig, seed: int) -> None:
        if source.operator != target.operator:
            raise InputError(
                f"cannot match a {source.operator!r} diffusion to a {target.operator!r} one; use one operator"
            )
        self.diffusions, self.config, self.seed = (source, target), config, seed
        self.times = shared_times(source, target, config)
        self.here: Side = prepare(source, self.times, config, np.random.default_rng([seed, 0]))
        self.there: Side = prepare(target, self.times, config, np.random.default_rng([seed, 1]))
        self.source: Cloud
        self.target: Cloud
        self.source, self.target = common_units(source, target)

    def by_cost(self, candidates: list[Candidate]) -> Matching:
        """The candidate of the lowest cost of Eq. 17, spread to all points (Sec. 4)."""
        costs = np.array([c.cost for c in candidates])
        chosen = int(costs.argmin())
        if self.config.refine == "deform":
            return self.by_fit([candidates[chosen]])
        mapped, residual = extend(self.here, self.there, candidates[chosen].landmarks, slice(None))
        confidence = confidence_of_residual(residual)
        if self.config.refine == "spectral":
            mapped = spectral_refinement(*self.diffusions, mapped)
        return self._matching(mapped, confidence, candidates, -costs, chosen, "undecided")

    def by_fit(self, candidates: list[Candidate]) -> Matching:
        """The candidate, or the combination of candidates, onto which the source deforms best."""
        coordinates = neighbourhoods(self.diffusions[0])
        quick, attachment = self._quick(coordinates)
        begun = run_tasks(lambda c: self._try(quick, c), [(c,) for c in candidates])
        scores = np.array([fit.score for fit in begun])
        rest = [(fit.pose, QUICK, EARLY) for fit in distinct(begun, PROMISING)]
        tried = run_tasks(quick.settle, rest)
        exchange = Exchange()
        if self.config.recombine:
            pool = recombine(quick, tried, exchange)
        else:
            pool = distinct(tried, exchange.donors)
        best, mapped, confidence = self._finish(quick, attachment, pool, coordinates)
        gaps = [np.linalg.norm(fit.moved - best.moved, axis=1).mean() for fit in begun]
        chosen = int(np.argmin(gaps))
        if self.config.refine != "deform" and not self.config.recombine:
            mapped = candidates[chosen].dense()
        if self.config.refine == "spectral":
            mapped = spectral_refinement(*self.diffusions, mapped)
        flip = flip_verdict(best, pool, candidates, self.target)
        return self._matching(mapped, confidence, candidates, scores, chosen, flip)

    def _quick(self, coordinates: NDArray[np.float32]) -> tuple[Registration, Attachment]:
        """Deformations with few nodes, of the samples alone, and how all points hang on the nodes."""
        nodes = max(2, min(self.config.nodes, len(self.source) // 4))
        rows = self.here.samples
        graph, attachment = NodeGraph.over(coordinates, self.source.points, rows, nodes)
        quick = Registration.between(graph, attachment, self.source, self.target, rows, self.there.samples)
        return quick, attachment

    def _try(self, quick: Registration, candidate: Candidate) -> Fit:
        goal = candidate.at_samples
        pose = quick.follow(self.target.points[goal], self.target.normals[goal], QUICK)
        return quick.settle(pose, QUICK, 0, EARLY)

    def _finish(
        self,
        quick: Registration,
        attachment: Attachment,
        pool: list[Fit],
        coordinates: NDArray[np.float32],
    ) -> tuple[Fit, NDArray[np.int64], NDArray[np.float64]]:
        """Look at good fits with fine nodes, settle the best of them and take the one that fits best then.

        Returns
        -------
        best : Fit
            Of the quick deformations.
        source_to_target : (n,) int64
        confidence : (n,) float64
        """
        final = self.config.refine == "deform"
        fine = FineDeformation(
            self.source,
            self.target,
            coordinates,
            self.here.samples,
            self.config.fine_nodes if final else self.config.nodes,
        )
        margin, most = ADOPTED
        near = [fit for fit in pool if fit.score > pool[0].score - margin][: most if final else 1]
        adopted = run_tasks(
            lambda fit: fine.judge(fine.adopt(quick.graph, attachment, fit.pose)), [(f,) for f in near]
        )
        coarse = np.array([fit.seen - COARSE_COST * fit.strain for fit in near])
        coarse -= FINE_COST * np.array([fit.strain for fit in adopted])
        worth = coarse + [fit.seen for fit in adopted]
        if final:
            order = np.argsort(-worth, kind="stable")[: self.config.finalists]
            order = order[worth[order] > worth.max() - FINALIST]
            settled = run_tasks(fine.settle, [(adopted[k].pose,) for k in order])
            chosen = int(np.argmax(coarse[order] + [fit.seen for fit in settled]))
            best, dense = near[order[chosen]], fine.dense(settled[chosen])
        else:
            best, dense = near[0], fine.dense(adopted[0])
        return best, dense.source_to_target, confidence_of_fit(dense, best, pool, attachment)

    def _matching(
        self,
        mapped: NDArray[np.int64],
        confidence: NDArray[np.float64],
        candidates: list[Candidate],
        scores: NDArray[np.float64],
        chosen: int,
        flip: str,
    ) -> Matching:
        landmarks = candidates[chosen].landmarks[:, 0]
        return Matching(
            source_to_target=mapped,
            landmarks=np.column_stack([landmarks, mapped[landmarks]]),
            cost=candidates[chosen].cost,
            confidence=confidence,
            restarts={
                "first": np.array([c.landmarks[0, 0] for c in candidates]),
                "partner": np.array([c.landmarks[0, 1] for c in candidates]),
                "paths": np.array([c.by_paths for c in candidates]),
                "cost": np.array([c.cost for c in candidates]),
                "score": scores,
                "chosen": np.arange(len(candidates)) == chosen,
            },
            flip=flip,
            seed=self.seed,
            config=self.config,
        )

"""Dense correspondences between two clouds from their diffusions (Sec. 4, and what holds with data missing).

With `MatchConfig.paper()` this is Sec. 4 as written. By default

1. many landmark sets are grown, each with its alternatives (left for right, arm for leg),
2. each is tried out: the source is deformed along its map and settles on the target, or the other way round;
   so are rigid motions where no set makes the surfaces meet,
3. parts are exchanged between the settled maps (one may have the arms right and another the legs),
4. the best are deformed finely; points of the two clouds that come to lie together are matches.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import run_tasks
from datasets_gen.records import InputError
from medial.diffusion import Diffusion
from medial.matching.common_units import MOST_POINTS, common_units, farthest_order
from medial.matching.confidence import confidence_of_fit, confidence_of_residual
from medial.matching.config import MatchConfig, Matching
from medial.matching.landmarks.candidates import Candidate, diffusion_sets, first_landmarks, grown
from medial.matching.landmarks.diffusion_landmarks import extend, middle_time, prepare, shared_times
from medial.matching.landmarks.medial_paths import MedialPaths
from medial.matching.landmarks.samples import cluster_samples, spectral_samples
from medial.matching.mirror_check import flip_verdict
from medial.matching.nearest import single_blas_thread
from medial.matching.neighbourhoods import Float32, neighbourhoods
from medial.matching.registration.direction import STAYING, End, Placed, Sets, Way, search
from medial.matching.registration.refinement import spectral_refinement
from medial.matching.registration.registration import Fit
from medial.matching.registration.selection import Finish

T = TypeVar("T")

ENOUGH = 1.35
"""Share of the source that is found plus share of the target, at which no further landmark sets are tried
and the search does not go on once more."""
BARELY = 1.1
"""The same, below which the search does not go on either: where half of each surface has no counterpart, what
scores better after more of it is wrong as often as right."""


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
    with single_blas_thread():
        return Pair(source, target, config or MatchConfig(), seed).match()


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
        if config.selection == "fit":
            found = pair.by_fit(pair.given(pairs))
        else:
            here, there = (end.side for end in pair.ends)
            found = pair.by_cost([grown(here, there, pairs, config)])
    return replace(found, landmarks=pairs)


class Pair:
    """Two clouds prepared for matching.

    Parameters
    ----------
    source, target
    config
    seed
    to_move : (n,) bool, optional
        The target is the mirror image of the source, point by point. Maps that leave most of these points in
        their medial region do not count, if there are others.

    Raises
    ------
    InputError
        If the operators differ: their diffusions cannot be compared.
    """

    def __init__(
        self,
        source: Diffusion,
        target: Diffusion,
        config: MatchConfig,
        seed: int,
        to_move: NDArray[np.bool_] | None = None,
    ) -> None:
        if source.operator != target.operator:
            raise InputError(
                f"cannot match a {source.operator!r} diffusion to a {target.operator!r} one; use one operator"
            )
        self.diffusions, self.config, self.seed, self.to_move = (source, target), config, seed, to_move
        self.times = shared_times(source, target, config)
        clouds = common_units(source, target)
        samples = self._samples()
        sides = [prepare(d, self.times, some) for d, some in zip(self.diffusions, samples, strict=True)]
        paths: list[MedialPaths | None] = [None, None]
        if config.paths and config.selection == "fit":
            paths = [*run_tasks(MedialPaths.of, [(cloud,) for cloud in clouds])]
        covers = run_tasks(farthest_order, [(cloud.points, MOST_POINTS) for cloud in clouds])
        self.ends = [End(*parts) for parts in zip(sides, clouds, paths, covers, strict=True)]

    def _samples(self) -> list[NDArray[np.int64]]:
        """S_P and S_Q: by spectral clustering (Sec. 4); where the fit decides, they cover the surface."""
        rngs = [np.random.default_rng([self.seed, k]) for k in (0, 1)]
        count = self.config.samples
        if self.config.selection == "fit":
            each = zip(self._coordinates, rngs, strict=True)
            return run_tasks(cluster_samples, [(x, count, rng) for x, rng in each])
        return [spectral_samples(d, count, rng) for d, rng in zip(self.diffusions, rngs, strict=True)]

    @cached_property
    def _coordinates(self) -> list[Float32]:
        """Of both clouds: in which pieces of limbs are close."""
        return run_tasks(neighbourhoods, [(diffusion,) for diffusion in self.diffusions])

    @cached_property
    def ways(self) -> list[Way]:
        """The source onto the target and, if both are wanted, the target onto the source."""
        here, there = self.ends
        both = self.config.both_ways and self.config.selection == "fit"
        first, second = self._coordinates
        wanted = [(here, there, first, False), (there, here, second, True)][: 2 if both else 1]

        def way(source: End, target: End, coordinates: Float32, backward: bool) -> Way:
            return Way(source, target, coordinates, self.times, self.config, backward, self.to_move)

        return run_tasks(way, wanted)

    def match(self) -> Matching:
        """Search for landmarks, and follow what they lead to."""
        config = self.config
        rngs = [np.random.default_rng([self.seed, 2]), np.random.default_rng([self.seed, 3])]
        if config.selection == "fit":
            draw = Sets(self.ways, rngs)
            return self.by_fit(draw.first(), draw.more)
        here, there = (end.side for end in self.ends)
        starts = first_landmarks(here, middle_time(self.times), config, rngs[0])
        sets = diffusion_sets(here, there, self.times, config, starts)
        return self.by_cost([grown(here, there, pairs, config) for pairs in sets])

    def given(self, landmarks: NDArray[np.int64]) -> list[list[Candidate]]:
        """The candidate that given landmarks (L, 2) make, for each way."""
        return [way.grown([landmarks], []) for way in self.ways]

    def by_cost(self, candidates: list[Candidate]) -> Matching:
        """The candidate of the lowest cost of Eq. 17, spread to all points (Sec. 4)."""
        costs = np.array([c.cost for c in candidates])
        chosen = int(costs.argmin())
        if self.config.refine == "deform":
            return self.by_fit([[candidates[chosen]]])
        here, there = self.ends
        mapped, residual = extend(here.side, there.side, candidates[chosen].landmarks, slice(None))
        confidence = confidence_of_residual(residual)
        if self.config.refine == "spectral":
            mapped = spectral_refinement(*self.diffusions, mapped)
        return self._matching(mapped, confidence, [candidates], -costs, chosen, "undecided")

    def by_fit(
        self, candidates: list[list[Candidate]], more: Callable[[], list[list[Candidate]]] | None = None
    ) -> Matching:
        """The candidate, or the combination of candidates, along which the clouds deform best.

        Parameters
        ----------
        candidates
            Of each way.
        more
            Further ones, for when none of the first makes most of both surfaces meet: then rigid motions are
            tried as well, and the search goes on once more if that helps too little.
        """
        ways, config = self.ways, self.config
        followed, settled = self._tried(candidates)
        if more is not None and self._seen(settled) < ENOUGH:
            others = more()
            candidates, before = _joined(candidates, others), (followed, settled)
            followed, settled = (_joined(a, b) for a, b in zip(before, self._tried(others), strict=True))
            if config.rigid_starts:
                settled = _joined(settled, [way.from_rigid() for way in ways])
        pools = self._moving(search(ways, self._moving(settled)))
        if more is not None and BARELY < self._seen(pools) < ENOUGH:
            pools = self._moving(search(ways, pools))
        starts, pool = self._placed(followed), self._placed(pools)
        best, dense = Finish(ways, pools, pool, config).chosen()
        at = pool[best]
        gaps = np.array([at.gap(start) for start in starts])
        mapped = dense.match
        if config.refine != "deform" and not config.recombine:
            mapped = candidates[0][int(gaps[: len(candidates[0])].argmin())].dense()
        if config.refine == "spectral":
            mapped = spectral_refinement(*self.diffusions, mapped)
        confidence = confidence_of_fit(dense, at, pool, ways[0].attachment, self.ends[0].side.samples)
        flip = flip_verdict(at, pool, candidates[0], self.ends[1].cloud)
        scores = np.array([start.score for start in starts])
        return self._matching(mapped, confidence, candidates, scores, int(gaps.argmin()), flip)

    def _tried(self, candidates: list[list[Candidate]]) -> tuple[list[list[Fit]], list[list[Fit]]]:
        """Of each way: the candidates, followed, and what the distinct ones settle to."""
        followed = [way.follow(each) for way, each in zip(self.ways, candidates, strict=True)]
        return followed, [way.settle(each) for way, each in zip(self.ways, followed, strict=True)]

    def _moving(self, fits: list[list[Fit]]) -> list[list[Fit]]:
        """Of each way: the fits that do not leave the body where it is; all of them if every one does."""
        each = zip(self.ways, fits, strict=True)
        moving = [[fit for fit in some if way.staying(fit) <= STAYING] for way, some in each]
        return moving if any(moving) else fits

    def _seen(self, fits: list[list[Fit]]) -> float:
        """The most that a fit sees that does not leave the body where it is."""
        every = ((way, fit) for way, each in zip(self.ways, fits, strict=True) for fit in each)
        return max((fit.seen for way, fit in every if way.staying(fit) <= STAYING), default=0.0)

    def _placed(self, fits: list[list[Fit]]) -> list[Placed]:
        tasks = [(way, fit) for way, each in zip(self.ways, fits, strict=True) for fit in each]
        return run_tasks(Way.placed, tasks)

    def _matching(
        self,
        mapped: NDArray[np.int64],
        confidence: NDArray[np.float64],
        candidates: list[list[Candidate]],
        scores: NDArray[np.float64],
        chosen: int,
        flip: str,
    ) -> Matching:
        every = [c for each in candidates for c in each]
        pairs = [
            c.landmarks[:, ::-1] if k else c.landmarks for k, each in enumerate(candidates) for c in each
        ]
        landmarks = pairs[chosen][:, 0]
        return Matching(
            source_to_target=mapped,
            landmarks=np.column_stack([landmarks, mapped[landmarks]]),
            cost=every[chosen].cost,
            confidence=confidence,
            restarts={
                "first": np.array([pair[0, 0] for pair in pairs]),
                "partner": np.array([pair[0, 1] for pair in pairs]),
                "paths": np.array([c.by_paths for c in every]),
                "backward": np.repeat([False, True][: len(candidates)], [len(each) for each in candidates]),
                "cost": np.array([c.cost for c in every]),
                "score": scores,
                "chosen": np.arange(len(every)) == chosen,
            },
            flip=flip,
            seed=self.seed,
            config=self.config,
        )


def _joined(first: list[list[T]], second: list[list[T]]) -> list[list[T]]:
    return [a + b for a, b in zip(first, second, strict=True)]

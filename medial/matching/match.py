"""Dense correspondences between two clouds from their diffusions (Sec. 4, and what holds with data missing).

With `MatchConfig.paper()` this is Sec. 4: `match_by_cost`. By default it is `match_by_fit`:

1. prepare both clouds (`prepared`),
2. draw candidates: many landmark sets, each with its alternatives, left for right or arm for leg
   (`candidate_batches`),
3. follow them: deform one cloud along each candidate, in both directions (`registration.direction`),
4. settle: let the surfaces meet, by rounds of closest points; also from rigid motions where no candidate
   promises to be right,
5. exchange parts between settled fits, as one may have the arms right and another one the legs, and invert
   fits for the opposite direction (`registration.search`),
6. add rivals on purpose, the best fit turned by half a turn; deform the good ones with more nodes, and select
   the most likely one by all evidence (`registration.selection`, `registration.evidence`); points of the two
   clouds that come to lie together are matches,
7. say how far each match can be trusted (`confidence`, `mirror_check`).
"""

import logging
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import run_tasks
from datasets_gen.records import InputError
from medial.diffusion import Diffusion
from medial.matching.candidate_batches import candidates, first_batch, first_landmarks_of, second_batch
from medial.matching.confidence import confidence_of_fit, confidence_of_residual
from medial.matching.config import MatchConfig
from medial.matching.fit_search import SearchedFits, search_from
from medial.matching.landmarks.candidates import (
    Candidate,
    diffusion_candidate,
    diffusion_sets,
    first_landmarks,
)
from medial.matching.landmarks.descriptors import middle_time
from medial.matching.landmarks.extrapolation import extrapolate_landmarks
from medial.matching.mirror_check import mirror_verdict
from medial.matching.nearest import single_blas_thread
from medial.matching.prepared import PreparedPair, prepare_pair
from medial.matching.registration.direction import Direction, one_side_each, pair_directions
from medial.matching.registration.evidence import likelihood_of_none, likelihood_of_other_limbs
from medial.matching.registration.placement import place
from medial.matching.registration.refinement import DenseFit
from medial.matching.registration.search import forward_first
from medial.matching.registration.selection import Finalist, FineSelection, groups
from medial.matching.result import UNCHECKED, Alternative, Matching
from medial.matching.without_strays import WithoutStrays, of_all_points
from medial.matching.zoomout import spectral_refinement

log = logging.getLogger(__name__)

WORTH_SAYING = 0.05
"""Probability from which another map is given as an alternative."""
LITTLE_SEEN = 1.0
"""Surface that meets, in [0, 2], below which clouds that show one side each do not show the same one."""


def match(
    source: Diffusion, target: Diffusion, config: MatchConfig | str | None = None, seed: int = 0
) -> Matching:
    """Match every source point to a target point.

    Parameters
    ----------
    source, target
        Diffusions of one kind of operator.
    config
        ``"default"``, ``"paper"`` or settings; see `MatchConfig.of`.
    seed
        Draws the samples, and the first landmarks where they are random. The same seed gives the same
        result for any number of threads.

    Returns
    -------
    Matching

    Raises
    ------
    InputError
        If the operators or their settings differ, or a cloud has no positive eigenvalue.
    """
    here, there = WithoutStrays.of(source), WithoutStrays.of(target)
    with single_blas_thread():
        found = match_pair(prepare_pair(here.diffusion, there.diffusion, config, seed))
    return of_all_points(found, here, there)


def extrapolate(
    source: Diffusion,
    target: Diffusion,
    landmarks: NDArray[np.integer],
    config: MatchConfig | str | None = None,
    seed: int = 0,
) -> Matching:
    """Grow a dense correspondence from given landmarks (Eq. 17), and refine it as configured.

    Parameters
    ----------
    source, target
        Diffusions of one kind of operator.
    landmarks : (L, 2)
        Source and target point ids.
    config, seed
        As for `match`; there is nothing to select.

    Returns
    -------
    Matching

    Raises
    ------
    InputError
        If a landmark is not a point of its cloud, or as for `match`.
    """
    pairs = np.asarray(landmarks, dtype=np.int64).reshape(-1, 2)
    for column, diffusion, name in ((0, source, "source"), (1, target, "target")):
        if len(pairs) == 0 or pairs[:, column].min() < 0 or pairs[:, column].max() >= len(diffusion):
            raise InputError(
                f"landmarks need {name} point ids in [0, {len(diffusion)}), got {pairs[:, column].tolist()}"
            )
    here, there = WithoutStrays.of(source), WithoutStrays.of(target)
    if here.stray[pairs[:, 0]].any() or there.stray[pairs[:, 1]].any():
        raise InputError("a landmark is a stray point, far from all others; choose others")
    pairs = np.column_stack([here.nearest[pairs[:, 0]], there.nearest[pairs[:, 1]]])
    with single_blas_thread():
        pair = prepare_pair(here.diffusion, there.diffusion, config, seed)
        if pair.config.selection == "fit":
            directions = pair_directions(pair)
            given = [c for direction in directions for c in candidates(direction, [pairs], [])]
            found = match_by_fit(pair, directions, given)
        else:
            both = pair.source.descriptors, pair.target.descriptors
            found = match_by_cost(pair, [diffusion_candidate(*both, pairs, pair.config)])
    return of_all_points(replace(found, landmarks=pairs), here, there)


def match_pair(pair: PreparedPair) -> Matching:
    """Draw candidates for a prepared pair, and make the map that its settings ask for."""
    if pair.config.selection == "fit":
        directions = pair_directions(pair)
        starts = first_landmarks_of(directions)
        first = first_batch(directions, starts)
        return match_by_fit(pair, directions, first, lambda: second_batch(directions, starts))
    here, there, rng = pair.source.descriptors, pair.target.descriptors, np.random.default_rng([pair.seed, 2])
    order = first_landmarks(here, middle_time(pair.times), pair.config, rng)
    sets = diffusion_sets(here, there, pair.times, pair.config, order)
    return match_by_cost(pair, [diffusion_candidate(here, there, pairs, pair.config) for pairs in sets])


def match_by_cost(pair: PreparedPair, tried: list[Candidate]) -> Matching:
    """The candidate of the lowest cost of Eq. 17, extended to all points (Sec. 4)."""
    config = pair.config
    costs = np.array([c.cost for c in tried])
    chosen = int(costs.argmin())
    if config.refine == "deform":
        return match_by_fit(pair, pair_directions(pair), [tried[chosen]])
    landmarks = tried[chosen].landmarks
    mapped, residual = extrapolate_landmarks(
        pair.source.descriptors, pair.target.descriptors, landmarks, slice(None)
    )
    if config.refine == "spectral":
        mapped = spectral_refinement(*pair.diffusions, mapped)
    return Matching(
        source_to_target=mapped,
        landmarks=landmarks,
        cost=tried[chosen].cost,
        confidence=confidence_of_residual(residual),
        restarts=restarts_table(tried, -costs, chosen),
        mirror_check=UNCHECKED,
        seed=pair.seed,
        config=config,
    )


def match_by_fit(
    pair: PreparedPair,
    directions: list[Direction],
    tried: list[Candidate],
    further: Callable[[], list[Candidate]] | None = None,
) -> Matching:
    """The candidate, or the combination of candidates, along which the clouds deform best.

    Parameters
    ----------
    pair
    directions
        One or two.
    tried
        Candidates of any direction.
    further
        As for `search_from`.
    """
    return _of_fits(pair, directions, search_from(directions, tried, further))


def _of_fits(pair: PreparedPair, directions: list[Direction], found: SearchedFits) -> Matching:
    """Select among the fits, refine the best one, and judge the map."""
    config, fits = pair.config, found.fits
    tried = forward_first(found.tried)
    starts = run_tasks(place, [(f,) for f in forward_first(found.followed)])
    placements = run_tasks(place, [(f,) for f in fits])
    selection = FineSelection(fits, placements, config)
    finalists = selection.finalists()
    rivals, best = selection.rivals(finalists), finalists[0]
    none = likelihood_of_none(directions[0].weights, best.fit.seen)
    if best.fit.seen < LITTLE_SEEN and one_side_each(pair):
        none = likelihood_of_other_limbs(none, best.log_likelihood)
        log.warning(
            "each cloud shows one side of the body, and not the same one: limbs of the other side fit as well"
        )
    (_, probability), *others = groups(rivals, none, placements)
    doubt = 1 - probability - sum(share for _, share in others)
    at, samples = placements[best.number], pair.source.descriptors.samples
    forward = [c for c in tried if not c.backward]

    def believed(dense: DenseFit, number: int, share: float) -> NDArray[np.float64]:
        hang = directions[0].attachment
        return confidence_of_fit(dense, number, rivals, none, placements, hang, samples, share)

    dense = selection.dense(best)
    mapped = dense.match
    gaps = np.array([at.gap(start) for start in starts])
    if config.refine != "deform" and not config.recombine and forward:
        mapped = forward[int(gaps[: len(forward)].argmin())].dense()
    if config.refine == "spectral":
        mapped = spectral_refinement(*pair.diffusions, mapped)
    chosen = int(gaps.argmin()) if tried else 0
    landmarks = tried[chosen].landmarks[:, 0] if tried else np.zeros(0, np.int64)
    alternatives = []
    for other, share in others if config.refine == "deform" else []:
        if share >= WORTH_SAYING and isinstance(other, Finalist):
            instead = selection.dense(other)
            alternatives.append(Alternative(share, instead.match, believed(instead, other.number, share)))
    return Matching(
        source_to_target=mapped,
        landmarks=np.column_stack([landmarks, mapped[landmarks]]),
        cost=tried[chosen].cost if tried else float("nan"),
        confidence=believed(dense, best.number, probability),
        restarts=restarts_table(tried, np.array([start.score for start in starts]), chosen),
        mirror_check=mirror_verdict(
            at, [(placements[o.number], share) for o, share in others], doubt, forward, pair.target.cloud
        ),
        seed=pair.seed,
        config=config,
        probability=probability,
        alternatives=tuple(alternatives),
    )


def restarts_table(
    tried: list[Candidate], scores: NDArray[np.float64], chosen: int
) -> dict[str, NDArray[np.generic]]:
    """The table `Matching.restarts`: one entry per candidate."""
    return {
        "first": np.array([c.landmarks[0, 0] for c in tried], dtype=np.int64),
        "partner": np.array([c.landmarks[0, 1] for c in tried], dtype=np.int64),
        "paths": np.array([c.by_paths for c in tried], dtype=bool),
        "backward": np.array([c.backward for c in tried], dtype=bool),
        "cost": np.array([c.cost for c in tried], dtype=np.float64),
        "score": scores,
        "chosen": np.arange(len(tried)) == chosen,
    }

"""Exchange of parts between fits: where one has a limb right and another has the other limb right, take both.

[KLF11] blend a collection of maps; here parts of the body are exchanged. Two fits differ on connected parts
of the node graph. Each such part of one is put into the other, the result is settled, and the fits of the
highest scores stay.

References
----------
[KLF11] Kim, Lipman, Funkhouser: Blended intrinsic maps. SIGGRAPH 2011.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from datasets_gen.compiled import run_tasks
from medial.matching.registration.closest_points import mean_distance
from medial.matching.registration.fit import Fit
from medial.matching.registration.registration import Registration, Schedule

F = TypeVar("F", bound=Fit)

DIFFERENT = 0.1
"""Distance, in sqrt(area), at which two fits place a node differently."""
SAME_FIT = 0.06
"""Fits whose points are on average closer than this are one."""
SAME_TRIAL = 0.02
"""Exchanges whose nodes are on average closer than this are one."""
WORTH_A_TRY = 0.15
"""An unsettled exchange that sees less than its base by more than this is not settled."""
BETTER = 0.002
"""Gain in score that counts as better."""
AGAIN = Schedule(follow=0, rounds=10, stiffness=(1.0, 0.01))
"""How an exchange is settled: softer from the start, as most of the body is in place."""
SMALLEST_PART = 2
"""Nodes of the smallest part that is exchanged."""
LARGEST_PART = 0.9
"""Share of the nodes of the largest part that is exchanged: more would be the other fit."""


@dataclass(frozen=True, kw_only=True)
class ExchangeLimits:
    """How much the exchange of parts tries."""

    rounds: int = 6
    """Rounds of exchanges; fewer if nothing new is left to try."""
    patience: int = 2
    """Early stop: rounds without a better fit after which it ends."""
    bases: int = 4
    """Best fits that receive parts."""
    donors: int = 14
    """Distinct fits kept."""
    settled: int = 6
    """Exchanges settled per round."""


def distinct(fits: Sequence[F], most: int, same: float = SAME_FIT) -> list[F]:
    """The best of each group of like fits, best first, at most `most`.

    Parameters
    ----------
    fits
    most
    same
        Mean distance of the points, in sqrt(area), up to which fits are alike.

    Returns
    -------
    list
    """
    kept: list[F] = []
    for fit in sorted(fits, key=lambda f: -f.score):
        if all(mean_distance(fit.moved, other.moved) > same for other in kept):
            kept.append(fit)
        if len(kept) == most:
            break
    return kept


def exchange_parts(registration: Registration, fits: Sequence[Fit], limits: ExchangeLimits) -> list[Fit]:
    """Exchange parts between fits until no better fit comes out (`ExchangeLimits.patience`).

    Parameters
    ----------
    registration
        The one that settled the fits.
    fits
        Of one direction.
    limits

    Returns
    -------
    list of Fit
        Distinct, best first.
    """
    pool: list[Fit] = distinct(fits, limits.donors)
    tried: set[tuple[int, int]] = set()
    everything = list(pool)  # keeps the fits alive, so that identities stay unique
    idle = 0
    for _ in range(limits.rounds):
        trials = _trials(registration, pool, limits, tried)
        if not trials:
            break
        again = run_tasks(lambda fit: registration.settle(fit.pose, AGAIN), [(fit,) for fit in trials])
        everything += again
        before, pool = pool[0].score, distinct(pool + again, limits.donors)
        idle = 0 if pool[0].score > before + BETTER else idle + 1
        if idle == limits.patience:
            break
    return pool


def _trials(
    registration: Registration, pool: list[Fit], limits: ExchangeLimits, tried: set[tuple[int, int]]
) -> list[Fit]:
    """The most promising exchanges, not settled."""
    arguments = []
    for base in pool[: limits.bases]:
        for donor in pool:
            key = (id(base), id(donor))
            if donor is not base and key not in tried:
                tried.add(key)
                arguments.append((registration, base, donor))
    found = [trial for trials in run_tasks(_exchanges, arguments) for trial in trials]
    found.sort(key=lambda fit: -fit.agreement)
    picked: list[Fit] = []
    for fit in found:
        places = (np.abs(fit.pose.positions - p.pose.positions) for p in picked)
        if all(np.linalg.norm(gap, axis=1).mean() > SAME_TRIAL for gap in places):
            picked.append(fit)
        if len(picked) == limits.settled:
            break
    return picked


def _exchanges(registration: Registration, base: Fit, donor: Fit) -> list[Fit]:
    """The base with one part taken from the donor, for each part on which they differ; not settled."""
    gap = np.linalg.norm(base.pose.positions - donor.pose.positions, axis=1)
    trials = []
    for part in registration.graph.parts(gap > DIFFERENT):
        if SMALLEST_PART <= len(part) <= LARGEST_PART * len(gap):
            fit = registration.judge(base.pose.mixed(donor.pose, part))
            if fit.agreement > base.agreement - WORTH_A_TRY:
                trials.append(fit)
    return trials

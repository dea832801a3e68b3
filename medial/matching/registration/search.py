"""The search among fits: try candidates out, invert fits of the opposite direction, exchange parts.

Lists of fits are flat; each fit knows its direction (`DirectedFit`).
"""

import math
from collections.abc import Iterable
from typing import Protocol, TypeVar

from datasets_gen.compiled import run_tasks
from medial.matching.landmarks.candidates import Candidate
from medial.matching.registration.direction import LIKE, DirectedFit, Direction
from medial.matching.registration.evidence import promise
from medial.matching.registration.exchange import distinct
from medial.matching.registration.placement import UNMOVED, place, unmoved

INVERTED = 8
"""Fits of each direction that are inverted for the other one, before and after parts are exchanged."""
CONFIRMED = 3
"""The same where one fit is sure."""
WITHIN = 0.25
"""After that, fits whose score is lower than the best by more than this are not inverted."""


class _Directed(Protocol):
    @property
    def backward(self) -> bool: ...


Item = TypeVar("Item", bound=_Directed)


def of(direction: Direction, items: Iterable[Item]) -> list[Item]:
    """The fits or candidates of a direction."""
    return [item for item in items if item.backward == direction.backward]


def forward_first(items: Iterable[Item]) -> list[Item]:
    """Fits or candidates of the source onto the target, then those of the opposite direction."""
    return sorted(items, key=lambda item: item.backward)


def follow(directions: list[Direction], candidates: list[Candidate]) -> list[DirectedFit]:
    """Deform along candidates, each in its direction."""
    return [fit for each in directions for fit in each.follow(of(each, candidates))]


def settle(directions: list[Direction], fits: list[DirectedFit]) -> list[DirectedFit]:
    """What the distinct fits of each direction settle to (`Direction.settle`)."""
    return [fit for each in directions for fit in each.settle(of(each, fits))]


def search(directions: list[Direction], fits: list[DirectedFit], sure: bool = False) -> list[DirectedFit]:
    """Invert settled fits for the opposite direction and exchange parts within each direction.

    Parameters
    ----------
    directions
        One or two.
    fits
        Settled fits, at least one.
    sure
        One of them promises enough: fewer are inverted, and no parts are exchanged.

    Returns
    -------
    list of DirectedFit
        Forward ones first, each direction best first. Fits that differ in one limb alone, which go as one
        until then, are kept apart.
    """
    most = CONFIRMED if sure else INVERTED
    donors = [fit for each in directions for fit in distinct(of(each, fits), most)]
    fits = with_inverses(directions, fits, donors)
    if not sure:
        fits = [fit for each in directions for fit in each.exchange(of(each, fits)) + of(each, fits)]
    best = max(fit.score for fit in fits)
    donors = [fit for each in directions for fit in distinct(of(each, fits), most, LIKE)]
    fits = with_inverses(directions, fits, [fit for fit in donors if fit.score > best - WITHIN])
    return [fit for each in directions for fit in distinct(of(each, fits), len(fits), LIKE)]


def with_inverses(
    directions: list[Direction], fits: list[DirectedFit], donors: list[DirectedFit]
) -> list[DirectedFit]:
    """Fits, and the inverse of some of them, registered again in the other direction if there is one."""
    if len(directions) == 1:
        return fits
    forward, backward = directions
    return fits + forward.invert(of(backward, donors)) + backward.invert(of(forward, donors))


def half_turned(
    directions: list[Direction], fits: list[DirectedFit], promised: list[float]
) -> list[DirectedFit]:
    """Rivals of the most promising fit of each direction, made on purpose (`Direction.half_turns`).

    Parameters
    ----------
    directions, fits
    promised
        `promises` of the fits.
    """
    rising = sorted(range(len(fits)), key=promised.__getitem__)
    best = {fits[k].direction: fits[k] for k in rising}  # the last one stays
    return [rival for each in directions if each in best for rival in each.half_turns(best[each])]


def promises(fits: list[DirectedFit]) -> list[float]:
    """What each fit foretells of the log-likelihood of its map (`evidence.promise`).

    One that leaves the body in place (`placement.UNMOVED`) promises nothing: -inf.
    """
    return run_tasks(_promise, [(fit,) for fit in fits])


def _promise(fit: DirectedFit) -> float:
    if unmoved(fit) > UNMOVED:
        return -math.inf
    return promise(fit.weights, place(fit).score, fit.medial_gap)


def moving(fits: list[DirectedFit]) -> list[DirectedFit]:
    """The fits that do not leave the body in place (`placement.UNMOVED`); all of them if every one does."""
    return [fit for fit in fits if unmoved(fit) <= UNMOVED] or fits

"""From candidates to settled fits: steps 3 to 5 of `medial.matching.match`, and rivals made on purpose."""

import math
from collections.abc import Callable
from typing import NamedTuple

from medial.matching.landmarks.candidates import Candidate
from medial.matching.registration.direction import DirectedFit, Direction
from medial.matching.registration.search import follow, half_turned, moving, promises, search, settle

SURE = 27.0
"""Promise of a fit from which nothing further is tried and no parts are exchanged. Much surface that meets is
not enough: after half a turn front lies on back, and more meets than under the right map."""


class SearchedFits(NamedTuple):
    """What was tried, and where it led."""

    tried: list[Candidate]
    followed: list[DirectedFit]
    """Fits of the candidates before they settled, one each."""
    fits: list[DirectedFit]
    """What the search ended with."""


def search_from(
    directions: list[Direction],
    tried: list[Candidate],
    further: Callable[[], list[Candidate]] | None = None,
) -> SearchedFits:
    """Settle candidates and search among their fits.

    Parameters
    ----------
    directions
        One or two.
    tried
        Candidates of any direction.
    further
        Makes more candidates, for when none of the first promises enough (`SURE`). If none of those does
        either, rigid motions are tried as well, and rivals are made of the best fits if that helps too
        little.
    """
    followed = follow(directions, tried)
    settled = settle(directions, followed)
    if further is None:
        return SearchedFits(tried, followed, moving(search(directions, moving(settled))))
    sure = promises_enough(settled)
    if not sure:
        more = further()
        more_followed = follow(directions, more)
        more_settled = settle(directions, more_followed)
        tried, followed, settled = tried + more, followed + more_followed, settled + more_settled
        sure = promises_enough(more_settled)
    if not sure and (directions[0].pair.config.rigid_starts or not settled):
        settled += [fit for direction in directions for fit in direction.from_rigid_motions()]
    fits = moving(search(directions, moving(settled), sure))
    if not sure and max(promised := promises(fits)) < SURE:
        fits = moving(fits + half_turned(directions, fits, promised))
    return SearchedFits(tried, followed, fits)


def promises_enough(fits: list[DirectedFit]) -> bool:
    """Whether one of the fits promises so much that nothing further is tried (`SURE`)."""
    return max(promises(fits), default=-math.inf) >= SURE

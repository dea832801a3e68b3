"""From candidates to settled fits: steps 3 to 5 of `medial.matching.match`, and rivals made on purpose."""

from collections.abc import Callable
from typing import NamedTuple

from medial.matching.landmarks.candidates import Candidate
from medial.matching.registration.direction import DirectedFit, Direction
from medial.matching.registration.search import follow, half_turned, moving, search, settle, surely_seen

ENOUGH = 1.35
"""Share of the source that is found plus share of the target, in [0, 2], from which no further landmark sets
are tried and the search does not go on once more."""
BARELY = 1.1
"""The same, up to which the search does not go on either: where half of each surface has no counterpart, what
scores better after more of it is wrong as often as right."""


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
        Makes more candidates, for when none of the first makes most of both surfaces meet. Then rigid motions
        are tried as well, and the search goes on once more if that helps too little.
    """
    followed = follow(directions, tried)
    settled = settle(directions, followed)
    if further is None:
        return SearchedFits(tried, followed, moving(search(directions, moving(settled))))
    if surely_seen(settled) < ENOUGH:
        more = further()
        more_followed = follow(directions, more)
        settled += settle(directions, more_followed)
        tried, followed = tried + more, followed + more_followed
        if directions[0].pair.config.rigid_starts or not settled:
            settled += [fit for direction in directions for fit in direction.from_rigid_motions()]
    fits = moving(search(directions, moving(settled)))
    if BARELY < surely_seen(fits) < ENOUGH:
        fits = moving(search(directions, fits))
    if surely_seen(fits) < ENOUGH:
        fits = moving(fits + half_turned(directions, fits))
    return SearchedFits(tried, followed, fits)

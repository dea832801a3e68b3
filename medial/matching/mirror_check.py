"""Left for right: what the deformation says of the map that the cost of Eq. 17 prefers.

Diffusion cannot tell a shape from its mirror image, so the cost prefers a mirrored map as often as the right
one. Rigid pieces cannot be mirrored, so the fit decides, unless another map fits as well.
"""

from medial.matching.common_units import CloudInUnits
from medial.matching.landmarks.candidates import Candidate
from medial.matching.registration.placement import Placement
from medial.matching.result import UNCHECKED

LIKELY = 0.25
"""Probability of all other maps and of none together from which it is open which one is right."""
RIVAL = 0.1
"""Mean distance, in sqrt(area), from which two maps are different ones."""


def mirror_verdict(
    best: Placement,
    others: list[tuple[Placement, float]],
    doubt: float,
    forward: list[Candidate],
    target: CloudInUnits,
) -> str:
    """Whether the selected map is the one of the lowest cost of Eq. 17.

    Parameters
    ----------
    best
        Of the selected fit.
    others
        Other maps and their probabilities.
    doubt
        Probability that none of the maps is right.
    forward
        Candidates that map the source onto the target. Those by path length have no cost, and no say.
    target

    Returns
    -------
    {"agrees", "overruled", "undecided", "unchecked"}
        It is; it is another one; other maps, or none at all, are about as likely; or Eq. 17 prefers none.
    """
    if doubt + sum(probability for other, probability in others if best.gap(other) > RIVAL) >= LIKELY:
        return "undecided"
    by_cost = min((c for c in forward if not c.by_paths), key=lambda c: c.cost, default=None)
    if by_cost is None:
        return UNCHECKED
    preferred = Placement(target.points[by_cost.at_samples], 0.0)
    return "overruled" if best.gap(preferred) > RIVAL else "agrees"

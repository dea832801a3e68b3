"""Left for right: what the deformation says of the map that the cost of Eq. 17 prefers.

Diffusion cannot tell a shape from its mirror image, so the cost prefers a mirrored map as often as the right
one. Rigid pieces cannot be mirrored, so the fit decides, unless another map fits as well.
"""

from medial.matching.common_units import CloudInUnits
from medial.matching.landmarks.candidates import Candidate
from medial.matching.registration.placement import MARGIN, Placement

RIVAL = 0.1
"""Mean distance, in sqrt(area), from which two maps are different ones."""


def mirror_verdict(
    best: Placement, placements: list[Placement], forward: list[Candidate], target: CloudInUnits
) -> str:
    """Whether the selected map is the one of the lowest cost of Eq. 17.

    Parameters
    ----------
    best
        Of the selected fit.
    placements
        Of all distinct fits, of both directions.
    forward
        Candidates that map the source onto the target. Those by path length have no cost, and no say.
    target

    Returns
    -------
    {"agrees", "overruled", "undecided"}
        It is; it is another one; or another map leads to a fit that is about as good (`Placement.lead`).
    """
    if any(best.gap(other) > RIVAL and best.lead(other) < MARGIN for other in placements):
        return "undecided"
    by_cost = min((c for c in forward if not c.by_paths), key=lambda c: c.cost)
    preferred = Placement(target.points[by_cost.at_samples], 0.0, 0.0)
    return "overruled" if best.gap(preferred) > RIVAL else "agrees"

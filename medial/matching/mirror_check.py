"""Left for right: what the orientation-preserving fit says about the map that intrinsic evidence prefers."""

from medial.matching.common_units import Cloud
from medial.matching.landmarks.candidates import Candidate
from medial.matching.registration.direction import Placed

MARGIN = 0.03
"""A map that leads its rival (`Placed.lead`) by less than this leaves it open which one is right."""
RIVAL = 0.1
"""Mean distance, in sqrt(area), from which two maps count as rivals."""


def flip_verdict(best: Placed, pool: list[Placed], candidates: list[Candidate], target: Cloud) -> str:
    """Whether the chosen map is that of the lowest cost of Eq. 17, a rival of it, or hardly better than one.

    Diffusion cannot tell a shape from its mirror image, so the cost prefers a mirrored map as often as the
    right one. Rigid pieces cannot be mirrored, so the fit decides, unless a rival fits as well.

    Parameters
    ----------
    best
        The chosen fit.
    pool
        All distinct fits, of both ways.
    candidates
        Landmark sets on the source.
    target

    Returns
    -------
    {"kept", "flipped", "undecided"}
    """
    if any(best.gap(rival) > RIVAL and best.lead(rival) < MARGIN for rival in pool):
        return "undecided"
    by_cost = min((c for c in candidates if not c.by_paths), key=lambda c: c.cost)
    return "flipped" if best.gap(Placed(target.points[by_cost.at_samples], 0.0, 0.0)) > RIVAL else "kept"

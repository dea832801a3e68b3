"""Confidence of matches.

A match is sure if the surfaces meet there, no other part of the body comes to lie there, its part of the body
is not torn off, no other map is as likely, and its map is probable.
"""

import numpy as np
from numpy.typing import NDArray

from medial.matching.registration.deformation_graph import Attachment
from medial.matching.registration.evidence import probabilities
from medial.matching.registration.placement import Placement
from medial.matching.registration.refinement import DenseFit
from medial.matching.registration.selection import Rival

Float = NDArray[np.float64]
Int = NDArray[np.int64]

SAME_PLACE = 0.1
"""Samples placed closer than this, in sqrt(area), agree."""
PROBABLE = 0.8
"""Matches of a map less probable than this are believed less, by the square of its probability over this."""


def confidence_of_fit(
    dense: DenseFit,
    number: int,
    rivals: list[Rival],
    none: float,
    placements: list[Placement],
    attachment: Attachment,
    samples: Int,
    probability: float,
) -> Float:
    """How far each match can be trusted: the product of five shares.

    Fits that agree about a place support each other there: their probabilities are added. Where two scans
    share little surface, fits can be wrong in the same way, so that the probability of the map itself counts,
    too.

    Parameters
    ----------
    dense
        The map.
    number
        Position of the quick fit that it came from.
    rivals
        What it is compared with, itself among them.
    none
        Log-likelihood of none of them being right.
    placements
        Of the quick fits.
    attachment
        How the source points hang on the nodes of the quick fits.
    samples : (s,) int64
        The source points that were placed.
    probability
        Of the map (`selection.groups`).

    Returns
    -------
    (n,) float64
        In [0, 1].
    """
    best = placements[number]
    odds = probabilities(np.array([each.log_likelihood for each in rivals]), none)
    there = [placements[each.number].places for each in rivals]
    agree = [np.linalg.norm(places - best.places, axis=1) < SAME_PLACE for places in there]
    shared = odds @ np.array(agree)  # (s,)
    undisputed = attachment.smoothed(samples, shared)
    likely = min(1.0, probability / PROBABLE) ** 2
    return np.clip(undisputed * likely * dense.held * dense.alone * dense.found, 0, 1)


def confidence_of_residual(residual: Float) -> Float:
    """Confidence from the residuals of Eq. 17 (n,): 1 for none, 1/2 for the median."""
    typical = max(float(np.median(residual)), np.finfo(float).tiny)
    return 1 / (1 + residual / typical)

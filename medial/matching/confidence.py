"""Confidence of matches.

A match is sure if the surfaces meet there, no other part of the body comes to lie there, its part of the body
is not torn off, and no other map fits as well.
"""

import numpy as np
from numpy.typing import NDArray

from medial.matching.registration.deformation_graph import Attachment
from medial.matching.registration.placement import Placement
from medial.matching.registration.refinement import DenseFit

Float = NDArray[np.float64]
Int = NDArray[np.int64]

RIVAL_TEMPERATURE = 0.03
"""A map that is worse by this, in score or merit (`Placement.lead`), is e times less likely."""
SAME_PLACE = 0.1
"""Samples placed closer than this, in sqrt(area), agree."""


def confidence_of_fit(
    dense: DenseFit, best: Placement, placements: list[Placement], attachment: Attachment, samples: Int
) -> Float:
    """How far each match can be trusted: the product of four shares.

    Parameters
    ----------
    dense
        The final map.
    best
        The quick fit that it came from.
    placements
        All distinct quick fits, of both directions.
    attachment
        How the source points hang on the nodes of the quick fits.
    samples : (s,) int64
        The source points that were placed.

    Returns
    -------
    (n,) float64
        In [0, 1].
    """
    weights = np.exp([min(0.0, -best.lead(fit) / RIVAL_TEMPERATURE) for fit in placements])
    agree = [np.linalg.norm(fit.places - best.places, axis=1) < SAME_PLACE for fit in placements]
    shared = (weights[:, None] * np.array(agree)).sum(axis=0) / weights.sum()  # (s,)
    undisputed = attachment.smoothed(samples, shared)
    return np.clip(undisputed * dense.held * dense.alone * dense.found, 0, 1)


def confidence_of_residual(residual: Float) -> Float:
    """Confidence from the residuals of Eq. 17 (n,): 1 for none, 1/2 for the median."""
    typical = max(float(np.median(residual)), np.finfo(float).tiny)
    return 1 / (1 + residual / typical)

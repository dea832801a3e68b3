"""How sure each match is: its surface met, nothing else did, nothing tore, and no other map fits as well."""

import numpy as np
from numpy.typing import NDArray

from medial.matching.registration.deformation_graph import Attachment
from medial.matching.registration.direction import Placed
from medial.matching.registration.refinement import Dense

Float = NDArray[np.float64]
Int = NDArray[np.int64]

RIVAL_TEMPERATURE = 0.03
"""A map that is worse by this (`Placed.lead`) is e times less likely."""
SAME_PLACE = 0.1
"""Samples placed closer than this, in sqrt(area), agree."""


def confidence_of_fit(
    dense: Dense, best: Placed, pool: list[Placed], attachment: Attachment, samples: Int
) -> Float:
    """Belief that each match is right, in [0, 1].

    Parameters
    ----------
    dense
        The final map.
    best
        The quick fit that it came from.
    pool
        All distinct quick fits, of both ways.
    attachment
        How the source points hang on the nodes of the quick fits.
    samples : (s,) int64
        The source points that were placed.

    Returns
    -------
    (n,) float64
    """
    weights = np.exp([min(0.0, -best.lead(fit) / RIVAL_TEMPERATURE) for fit in pool])
    agree = [np.linalg.norm(fit.places - best.places, axis=1) < SAME_PLACE for fit in pool]
    shared = (weights[:, None] * np.array(agree)).sum(axis=0) / weights.sum()  # (s,)
    undisputed = attachment.spread(samples, shared)
    return np.clip(undisputed * dense.held * dense.alone * dense.found, 0, 1)


def confidence_of_residual(residual: Float) -> Float:
    """Residuals of Eq. 17 relative to their median, mapped to [0, 1]: 1 fits perfectly, 1/2 is typical."""
    typical = max(float(np.median(residual)), np.finfo(float).tiny)
    return 1 / (1 + residual / typical)

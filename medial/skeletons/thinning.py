"""Shrinking and thinning: centres that scatter in joints and sheets are drawn together to curves."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from datasets_gen.points.neighbours import query_tree

Float = NDArray[np.float64]
Mask = NDArray[np.bool_]

NEAREST = 40
"""Centres that a centre is drawn to, at most."""
REACH = 1.0
"""They are within this many radii of the body around it."""
LINEAR = 0.85
"""Share of the largest principal moment from which centres lie on a line: then they move onto it, and else
to their mean. A half disc has 0.78."""


def filled(near: csr_array, values: Float, known: Mask) -> tuple[Float, Mask]:
    """Values of unknown points from neighbours that are known, ring by ring.

    Parameters
    ----------
    near : (n, n)
        Which points are neighbours.
    values : (n, d)
    known : (n,)

    Returns
    -------
    values : (n, d)
    known : (n,) bool
        False where no known point can be reached.
    """
    values, known = np.where(known[:, None], values, 0.0), known.copy()
    while True:
        count = near @ known.astype(np.float64)
        reached = ~known & (count > 0)
        if not reached.any():
            return values, known
        values[reached] = (near @ values)[reached] / count[reached, None]
        known |= reached


def thinned_centers(centers: Float, radii: Float, rounds: int, spacing: float) -> Float:
    """Centres (n, 3) moved towards curves, in rounds.

    A centre whose neighbours lie along a line is projected to that line (moving least squares in one
    dimension), so that the ends of a branch stay where they are. Others, in joints and sheets, move to the
    mean of their neighbours.

    Parameters
    ----------
    centers : (n, 3)
    radii : (n,)
        Of the body there: neighbours are within `REACH` of these.
    rounds
    spacing
        Of the surface points: the least reach.
    """
    count = min(NEAREST, len(centers))
    reach = np.maximum(REACH * radii, spacing)
    moved = centers.copy()
    for _ in range(rounds):
        gaps, index = query_tree(cKDTree(moved), moved, k=count)
        gaps, index = gaps.reshape(len(moved), -1), index.reshape(len(moved), -1)
        weights = np.maximum(1 - (gaps / reach[:, None]) ** 2, 0) ** 2
        moved = _drawn_together(moved, index, weights)
    return moved


def _drawn_together(places: Float, index: NDArray[np.intp], weights: Float) -> Float:
    """One round: projections to lines, or means."""
    share = weights / weights.sum(axis=1, keepdims=True)
    mean = np.einsum("nk,nkd->nd", share, places[index])
    offset = places[index] - mean[:, None]
    values, vectors = np.linalg.eigh(np.einsum("nk,nki,nkj->nij", share, offset, offset))
    along = vectors[:, :, 2]
    linear = values[:, 2] > LINEAR * np.maximum(values.sum(axis=1), 1e-300)
    slid = np.einsum("nd,nd->n", places - mean, along)
    return np.where(linear[:, None], mean + slid[:, None] * along, mean)

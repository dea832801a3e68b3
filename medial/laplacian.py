"""Gaussian weights alpha, the combination of Eqs. 14-15 and the symmetric problem of Eq. 8."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array, diags_array
from scipy.spatial import cKDTree

from medial.checks import check_points

BANDWIDTH = 4.0  # h of the Gaussian in squared sampling distances
SMALLEST_WEIGHT = 1e-3  # Gaussian weights below this are dropped beyond the nearest neighbours
NEAREST = 8  # neighbours every point keeps


def gaussian_weights(
    points: NDArray[np.floating], spacing: float | None = None, nearest: int = NEAREST
) -> csr_array:
    """Gaussian weights alpha = exp(-|p - q|^2 / h), h = 4 squared sampling distances [BSW09].

    Parameters
    ----------
    points : (n, 3)
    spacing
        Sampling distance, in the units of `points`; by default sqrt(area per point) is approximated by the
        mean distance to the nearest neighbour.
    nearest
        Every point keeps at least this many neighbours, at their distance's bandwidth.

    Returns
    -------
    (n, n) float64 csr_array
        Symmetric to the bit, zero diagonal.
    """
    points = check_points(points)
    n = len(points)
    nearest = min(nearest, n - 1)
    tree = cKDTree(points)
    distances, neighbours = tree.query(points, k=nearest + 1)
    if spacing is None:
        spacing = float(distances[:, 1].mean())
    h = BANDWIDTH * spacing**2
    close = tree.query_pairs(np.sqrt(h * -np.log(SMALLEST_WEIGHT)), output_type="ndarray")
    kept = np.column_stack([np.repeat(np.arange(n), nearest), neighbours[:, 1:].ravel()])
    kept.sort(axis=1)
    pairs = np.unique(np.concatenate([close, kept[kept[:, 0] != kept[:, 1]]]), axis=0)
    i, j = pairs[:, 0], pairs[:, 1]
    square = ((points[i] - points[j]) ** 2).sum(axis=1)
    local = np.maximum(h, distances[i, -1] * distances[j, -1])
    alpha = np.exp(-square / local)
    return mirrored(i, j, alpha, n)


def mirrored(
    i: NDArray[np.integer], j: NDArray[np.integer], values: NDArray[np.float64], n: int
) -> csr_array:
    """The symmetric (n, n) matrix with `values` at (i, j) and (j, i)."""
    rows, cols = np.concatenate([i, j]), np.concatenate([j, i])
    matrix = csr_array(coo_array((np.concatenate([values, values]), (rows, cols)), shape=(n, n)).tocsr())
    matrix.sort_indices()
    return matrix


def degrees(weights: csr_array, areas: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weighted sums d(p_i) over j != i (Eq. 14)."""
    return np.asarray(weights @ areas) - weights.diagonal() * areas


def combine(phi: csr_array, alpha: csr_array, areas: NDArray[np.float64], eta: float = 0.5) -> csr_array:
    """Normalised combination sigma of medial and Gaussian weights (Eqs. 14-15).

    Parameters
    ----------
    phi, alpha : (n, n) csr_array
        Medial similarity and Gaussian weights.
    areas : (n,)
        Dual areas.
    eta
        Share of the Gaussian weights, in [0, 1].

    Returns
    -------
    (n, n) csr_array
        A point of zero degree in one of the two keeps only the other.
    """
    return csr_array((1 - eta) * _normalised(phi, areas) + eta * _normalised(alpha, areas))


def _normalised(weights: csr_array, areas: NDArray[np.float64]) -> csr_array:
    degree = degrees(weights, areas)
    scale = np.where(degree > 0, 1 / np.sqrt(np.where(degree > 0, degree, 1)), 0)
    scaled = weights.copy()
    rows = np.repeat(np.arange(len(areas)), np.diff(weights.indptr))
    scaled.data = weights.data * (scale[rows] * scale[weights.indices])
    return scaled


def laplacian(weights: csr_array, areas: NDArray[np.float64]) -> csr_array:
    """The matrix S of (Delta f)_i = sum_j w_ij a_j (f_i - f_j) times the area of i (Eq. 8).

    ``S psi = lambda A psi`` with A = diag(areas) is the symmetric form of Eq. 8.
    """
    rows = np.repeat(np.arange(len(areas)), np.diff(weights.indptr))
    scaled = csr_array(
        (weights.data * (areas[rows] * areas[weights.indices]), weights.indices, weights.indptr)
    )
    scaled = csr_array(scaled)
    return csr_array(diags_array(np.asarray(scaled.sum(axis=1))) - scaled)

"""Gaussian weights alpha, the combination of Eqs. 14-15 and the symmetric problem of Eq. 8, all sparse."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array
from scipy.spatial import cKDTree

from datasets_gen.points.neighbours import query_tree
from medial.departures import ALL_DEPARTURES, Departures
from medial.sparse import symmetric

BANDWIDTH = 3.0  # h of the Gaussian in areas per point: about (twice the mean nearest distance)^2
SMALLEST_WEIGHT = 1e-3  # Gaussian weights below this are dropped beyond the nearest neighbours
NEAREST = 8  # neighbours every point keeps
WIDEST = 0.7  # least bandwidth in squared distances to the last of them
REACHED = 64  # pi * BANDWIDTH * ln(1 / SMALLEST_WEIGHT): neighbours with larger weights
TINY = float(np.finfo(np.float64).tiny)  # smallest weight kept without truncation


class Gaussian(NamedTuple):
    """Gaussian weights of a cloud.

    Attributes
    ----------
    weights : (n, n) csr_array
        alpha, symmetric to the bit, zero diagonal.
    bandwidths : (nnz,) float64
        h of each entry of `weights`, in squared units.
    """

    weights: csr_array
    bandwidths: NDArray[np.float64]


def gaussian_weights(
    points: NDArray[np.float64],
    areas: NDArray[np.float64],
    tree: cKDTree | None = None,
    departures: Departures = ALL_DEPARTURES,
) -> Gaussian:
    """Gaussian weights alpha = exp(-|p - q|^2 / h) of Eq. 2 [BSW09].

    The bandwidth follows the sampling: h is three times the area that the two points stand for (geometric
    mean), and at least large enough to reach the eight nearest neighbours, which every point keeps, so that
    no point is isolated. On a uniform cloud h is constant, about the square of twice the mean nearest
    distance.

    Parameters
    ----------
    points : (n, 3)
        Checked.
    areas : (n,)
        Surface area of each point (`medial.surface_areas`).
    tree
        Of the points.
    departures
        `adaptive_bandwidth` and `truncation` matter.
    """
    tree = cKDTree(points) if tree is None else tree
    if not (departures.adaptive_bandwidth and departures.truncation):
        return _weights_of_all(points, areas, tree, departures)
    n = len(points)
    nearest, reached = min(NEAREST, n - 1), min(REACHED, n - 1)
    distances, neighbours = query_tree(tree, points, k=reached + 1)
    rows = np.repeat(np.arange(n), reached)
    cols = neighbours[:, 1:].ravel()
    h = _bandwidths(rows, cols, areas[neighbours[:, : nearest + 1]].mean(axis=1), distances[:, nearest])
    alpha = np.exp(-(distances[:, 1:].ravel() ** 2) / h)
    kept = (alpha >= SMALLEST_WEIGHT) | (np.tile(np.arange(reached), n) < nearest)
    kept &= rows != cols
    low, high = np.minimum(rows, cols)[kept], np.maximum(rows, cols)[kept]
    _, first = np.unique(low * n + high, return_index=True)
    low, high, alpha, h = low[first], high[first], alpha[kept][first], h[kept][first]
    return Gaussian(symmetric(low, high, alpha, n), symmetric(low, high, h, n).data)


def _bandwidths(
    rows: NDArray[np.integer],
    cols: NDArray[np.integer],
    smooth: NDArray[np.float64],
    far: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Adaptive h of some pairs, from areas averaged over neighbours and distances to the eighth of them."""
    return np.maximum(
        BANDWIDTH * np.sqrt(smooth[rows] * smooth[cols]), WIDEST * np.maximum(far[rows], far[cols]) ** 2
    )


def _weights_of_all(
    points: NDArray[np.float64], areas: NDArray[np.float64], tree: cKDTree, departures: Departures
) -> Gaussian:
    """Gaussian weights with one h, or without truncation: all pairs within reach of the widest Gaussian."""
    n = len(points)
    smooth, far = np.full(n, areas.mean()), np.zeros(n)
    if departures.adaptive_bandwidth:
        nearest = min(NEAREST, n - 1)
        distances, neighbours = query_tree(tree, points, k=nearest + 1)
        smooth, far = areas[neighbours].mean(axis=1), distances[:, nearest]
    least = SMALLEST_WEIGHT if departures.truncation else TINY
    widest = max(BANDWIDTH * float(smooth.max()), WIDEST * float(far.max()) ** 2)
    i, j = tree.query_pairs(np.sqrt(widest * np.log(1 / least)), output_type="ndarray").T
    h = _bandwidths(i, j, smooth, far)
    alpha = np.exp(-((points[i] - points[j]) ** 2).sum(axis=1) / h)
    kept = alpha >= least
    i, j, alpha, h = i[kept], j[kept], alpha[kept], h[kept]
    return Gaussian(symmetric(i, j, alpha, n), symmetric(i, j, h, n).data)


def degrees(weights: csr_array, areas: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weighted sums d(p_i) over j != i (Eq. 14)."""
    return np.asarray(weights @ areas) - weights.diagonal() * areas


def combine(
    phi: csr_array,
    alpha: csr_array,
    areas: NDArray[np.float64],
    eta: float = 0.5,
    rates: NDArray[np.float64] | float = 1.0,
) -> csr_array:
    """Normalised combination sigma of medial and Gaussian weights (Eqs. 14-15).

    Parameters
    ----------
    phi, alpha : (n, n) csr_array
        Medial similarity and Gaussian weights.
    areas : (n,)
        Dual areas.
    eta
        Share of the Gaussian weights, in [0, 1].
    rates : (nnz,) or float
        Factors of the entries of `alpha` after normalisation; see `diffusion_rates`.

    Returns
    -------
    (n, n) csr_array
        A point of zero degree in one of the two keeps only the other.
    """
    surface = normalised(alpha, areas)
    surface.data *= rates
    return csr_array((1 - eta) * normalised(phi, areas) + eta * surface)


def diffusion_rates(
    bandwidths: NDArray[np.float64], total_area: float, reference_points: float
) -> NDArray[np.float64]:
    """Factors that make the Gaussian part of Eq. 15 diffuse as it does on a cloud of the reference size.

    Normalised by its degree, a Gaussian of bandwidth h diffuses h / 4 per unit of time, so a finer cloud with
    its smaller h would diffuse more slowly. The factor h_ref / h undoes that, with h_ref the bandwidth at
    `reference_points` points on `total_area`.
    """
    return BANDWIDTH * total_area / reference_points / bandwidths


def normalised(weights: csr_array, areas: NDArray[np.float64]) -> csr_array:
    """w_ij / sqrt(d_i d_j) with the degrees of Eq. 14; rows of zero degree stay zero."""
    degree = degrees(weights, areas)
    scale = np.where(degree > 0, 1 / np.sqrt(np.where(degree > 0, degree, 1)), 0)
    rows = np.repeat(np.arange(len(areas)), np.diff(weights.indptr))
    data = weights.data * (scale[rows] * scale[weights.indices])
    return csr_array((data, weights.indices, weights.indptr), shape=weights.shape)


def laplacian(weights: csr_array, areas: NDArray[np.float64]) -> csr_array:
    """The matrix S of (Delta f)_i = sum_j w_ij a_j (f_i - f_j) times the area of i (Eq. 8).

    ``S psi = lambda A psi`` with A = diag(areas) is the symmetric form of Eq. 8.
    """
    rows = np.repeat(np.arange(len(areas)), np.diff(weights.indptr))
    data = weights.data * (areas[rows] * areas[weights.indices])
    scaled = csr_array((data, weights.indices, weights.indptr), shape=weights.shape)
    return csr_array(diags_array(np.asarray(scaled.sum(axis=1))) - scaled)

r"""Eqs. 2, 3, 8, 14 and 15 as the paper writes them: plain NumPy for small clouds, the reference of the code.

The fast forms are in `medial.laplacian.weights`.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def gaussian(points: Array, h: float) -> Array:
    """Alpha of Eq. 2 between all points: exp(-|p - q|^2 / h).

    In the code: h follows the local sampling and every point keeps its eight nearest neighbours, so that no
    point of an uneven scan is isolated; weights below 1e-3 are dropped otherwise.

    Parameters
    ----------
    points : (n, 3)
    h
        Bandwidth, in squared units.

    Returns
    -------
    (n, n), no unit
    """
    return np.exp(-((points[:, None] - points) ** 2).sum(axis=2) / h)


def laplacian_over_medial_axis(
    f: Array, medial_points: Array, masses: Array, density: Array, h: float
) -> Array:
    r"""Eq. 2: the Medial Laplacian of f as a sum over samples of the medial axis.

    .. math::

        \Delta_M f(p) = f(p) \int_M \alpha(p, q)\, |\tilde\Gamma(q)|\, dq
        - \int_M f(q)\, \alpha(p, q)\, |\tilde\Gamma(q)|\, dq

    In the code: nothing computes it, because it needs an explicit medial axis; Eq. 3 is the same integral
    over the surface.

    Parameters
    ----------
    f : (n,)
        Values at the medial points.
    medial_points : (n, 3)
    masses : (n,)
        Part of the medial axis that each point stands for.
    density : (n,)
        Smoothed density at the medial points (Eq. 1).
    h
        Bandwidth of the Gaussian, in squared units.

    Returns
    -------
    (n,)
    """
    return weighted_differences(f, gaussian(medial_points, h), masses * density)


def laplacian_over_surface(f: Array, medial_points: Array, areas: Array, h: float) -> Array:
    r"""Eq. 3: the Medial Laplacian of f as a sum over samples of the surface.

    .. math::

        \Delta_S f(p) = f(\hat p) \int_S \alpha(\hat p, \hat q)\, dq
        - \int_S f(\hat q)\, \alpha(\hat p, \hat q)\, dq

    The density of Eq. 1 is implicit: medial points of large parts of the surface occur more often.

    In the code: phi (Eq. 7) takes the place of the Gaussian between medial points, which need not be known;
    that is Eq. 8.

    Parameters
    ----------
    f : (n,)
        Values at the medial points of the surface points.
    medial_points : (n, 3)
        Medial point of each surface point.
    areas : (n,)
        Surface area of each surface point, in squared units.
    h
        Bandwidth of the Gaussian, in squared units.

    Returns
    -------
    (n,)
    """
    return weighted_differences(f, gaussian(medial_points, h), areas)


def point_cloud_laplacian(f: Array, phi: Array, areas: Array) -> Array:
    r"""Eq. 8: the point cloud Medial Laplacian of f.

    .. math::

        \Delta_P f(p) = f(p) \sum_{q \in P} \phi(p, q)\, |{\star q}|
        - \sum_{q \in P} f(q)\, \phi(p, q)\, |{\star q}|

    In the code: the matrix S = diag(a) * Delta, which is symmetric, so that ``S psi = lambda A psi`` gives
    the eigenpairs of Delta (`medial.laplacian.weights.laplacian`).

    Parameters
    ----------
    f : (n,)
    phi : (n, n)
        Medial similarity (Eq. 7), or sigma (Eq. 15).
    areas : (n,)
        Dual areas (Eq. 10), in squared units.

    Returns
    -------
    (n,)
    """
    return weighted_differences(f, phi, areas)


def weighted_differences(f: Array, weights: Array, areas: Array) -> Array:
    """``f(p) sum_q w(p, q) a(q) - sum_q f(q) w(p, q) a(q)``: the form that Eqs. 2, 3 and 8 share, (n,)."""
    return f * (weights @ areas) - weights @ (f * areas)


def weighted_degrees(weights: Array, areas: Array) -> Array:
    r"""Eq. 14: the sums d(p_i) of the weights over j != i.

    .. math::

        d_\phi(p_i) = \sum_{j \neq i} |{\star p_j}|\, \phi(p_i, p_j),
        \qquad d_\alpha(p_i) = \sum_{j \neq i} |{\star p_j}|\, \alpha(p_i, p_j)

    In the code: the same on sparse matrices (`medial.laplacian.weights.degrees`).

    Parameters
    ----------
    weights : (n, n)
        phi or alpha.
    areas : (n,)
        Dual areas, in squared units.

    Returns
    -------
    (n,) in squared units
    """
    others = weights - np.diag(np.diag(weights))
    return np.asarray(others @ areas)


def combined_weights(
    phi: Array, alpha: Array, areas: Array, eta: float = 0.5, rates: Array | float = 1.0
) -> Array:
    r"""Eq. 15: sigma, the combination of medial similarity and Gaussian weights.

    .. math::

        \sigma(p_i, p_j) = (1 - \eta) \frac{\phi(p_i, p_j)}{\sqrt{d_\phi(p_i)\, d_\phi(p_j)}}
        + \eta \frac{\alpha(p_i, p_j)}{\sqrt{d_\alpha(p_i)\, d_\alpha(p_j)}}

    In the code: alpha has an adaptive bandwidth h (see `gaussian`), and its normalised entries are multiplied
    by h_ref / h. A Gaussian normalised by its degree diffuses h / 4 per unit of time, so that a finer cloud,
    whose h is smaller, would diffuse more slowly.

    Parameters
    ----------
    phi, alpha : (n, n)
        Medial similarity (Eq. 7) and Gaussian weights.
    areas : (n,)
        Dual areas, in squared units.
    eta
        Share of the Gaussian weights, in [0, 1].
    rates : (n, n) or float
        Factors of the normalised Gaussian weights; 1 in the paper.

    Returns
    -------
    (n, n), in one over squared units
        A point of zero degree in one of the two keeps only the other.
    """
    parts = []
    for weights in (phi, alpha):
        degrees = weighted_degrees(weights, areas)
        root = np.sqrt(np.where(degrees > 0, degrees, np.inf))
        parts.append(weights / np.outer(root, root))
    return (1 - eta) * parts[0] + eta * rates * parts[1]

r"""Eqs. 4-7 as the paper writes them: plain NumPy for small clouds, the reference of the compiled kernels.

Positions and normals have shape (..., 3) and broadcast; lengths are in the units of the cloud. The fast form,
`medial.similarity.similarity`, does not look at most pairs.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

OPPOSED = 1e-6
"""Tangency F up to which the normals oppose every ball through the two points."""


def candidate_balls(p_i: Array, p_j: Array, n_i: Array, n_j: Array) -> tuple[Array, Array]:
    r"""The ball c_ij, r_ij that two oriented points suggest; the paper takes it from [BS12].

    Of all balls through both points, centred on their bisector plane, the one whose outward normals at the
    points agree best with n_i and n_j in least squares. With d = p_i - p_j, D = d.d, a_i = n_i.d and
    a_j = n_j.d, and F in [0, 2], which is 2 where the ball is tangent to both:

    .. math::

        F &= \sqrt{2 + 2\, n_i \cdot n_j - 4\, a_i a_j / D} \\
        g &= \frac{D}{2 (a_i - a_j)}, \qquad k = \frac{2 a_j}{D} \\
        c &= p_i - g\, (n_i + n_j - k\, d), \qquad r = g F

    Parameters
    ----------
    p_i, p_j : (..., 3)
        Positions.
    n_i, n_j : (..., 3)
        Outward unit normals.

    Returns
    -------
    centers : (..., 3)
    radii : (...)
        0, as is the centre, where no ball inside the shape touches both points: a_i <= a_j, or F near 0.
    """
    d = p_i - p_j
    square, a_i, a_j = (d * d).sum(-1), (n_i * d).sum(-1), (n_j * d).sum(-1)
    there = (square > 0) & (a_i > a_j)
    square, gap = np.where(there, square, 1.0), np.where(there, a_i - a_j, 1.0)
    tangency = np.sqrt(np.maximum(2 + 2 * (n_i * n_j).sum(-1) - 4 * a_i * a_j / square, 0))
    there &= tangency > OPPOSED
    g, k = square / (2 * gap), 2 * a_j / square
    centers = p_i - g[..., None] * (n_i + n_j - k[..., None] * d)
    return np.where(there[..., None], centers, 0.0), np.where(there, g * tangency, 0.0)


def normal_deviation(p_i: Array, p_j: Array, n_i: Array, n_j: Array, centers: Array, radii: Array) -> Array:
    r"""Eq. 4: tau, how far a ball is from being tangent to the surface at both points.

    .. math::

        \tau(p_i, p_j) = |n_i - s_i| + |n_j - s_j|

    s are the ball's outward normals at the two points. In the code: both terms are equal for a
    candidate ball, so that tau = 2 sqrt(2 - F) (`medial.similarity.candidate_ball`) and bounds on F discard
    whole groups of pairs.

    Parameters
    ----------
    p_i, p_j, n_i, n_j : (..., 3)
        Positions and outward unit normals.
    centers : (..., 3)
    radii : (...)
        Candidate balls; radii positive.

    Returns
    -------
    (...) in [0, 4], no unit
    """
    s_i, s_j = (p_i - centers) / radii[..., None], (p_j - centers) / radii[..., None]
    return np.asarray(np.linalg.norm(n_i - s_i, axis=-1) + np.linalg.norm(n_j - s_j, axis=-1))


def summed_depth(centers: Array, radii: Array, points: Array, weights: Array | None = None) -> Array:
    r"""Eq. 5: gamma, how far a ball is from being empty.

    .. math::

        \gamma(p_i, p_j) = \sum_{p \in P} \mu(c_{ij}, r_{ij}, p)

    The sum of the depths mu (Eq. 6) of all points. In the code: a point counts with a weight
    (`medial.areas.surface_cells.density_weights`), because the sum grows with the number of points while
    sigma_e stays; and summing stops once phi must fall below the cut-off.

    Parameters
    ----------
    centers : (..., 3)
    radii : (...)
        Balls.
    points : (n, 3)
        The cloud.
    weights : (n,), optional
        How much each point counts; 1 in the paper.

    Returns
    -------
    (...), in points
    """
    depths = depth_in_ball(centers[..., None, :], radii[..., None], points)
    return np.asarray(depths @ (np.ones(len(points)) if weights is None else weights))


def depth_in_ball(centers: Array, radii: Array, points: Array) -> Array:
    r"""Eq. 6: mu, how deep a point lies inside a ball; 1 at the centre, 0 on the sphere and outside.

    .. math::

        \mu(c, r, p) = \begin{cases}
        1 - \left(\frac{|p - c|}{r}\right)^4 & \text{if } |p - c| < r \\
        0 & \text{otherwise}
        \end{cases}

    In the code: the same, in single precision relative to a centre nearby.

    Parameters
    ----------
    centers, points : (..., 3)
    radii : (...)
        Positive.

    Returns
    -------
    (...) in [0, 1], no unit
    """
    distances = np.linalg.norm(points - centers, axis=-1)
    return np.where(distances < radii, 1 - (distances / radii) ** 4, 0.0)


def medial_similarity(gamma: Array, tau: Array, sigma_e: float = 5.0, sigma_t: float = 0.7) -> Array:
    r"""Eq. 7: phi, the likelihood that two points lie on a common medial ball.

    .. math::

        \phi(p_i, p_j) = \exp\left(-\left(\frac{\gamma(p_i, p_j)}{\sigma_e}\right)^2
        - \left(\frac{\tau(p_i, p_j)}{\sigma_t}\right)^2\right)

    In the code: phi below a cut-off (1e-6) is dropped, which is what makes the search fast; and balls larger
    than the cloud's smallest width have phi = 0, because Eq. 6 measures depth relative to the radius, so that
    ever larger balls would count as ever emptier and link far points.

    Parameters
    ----------
    gamma : (...)
        Summed depth (Eq. 5), in points.
    tau : (...)
        Deviation of the normals (Eq. 4).
    sigma_e, sigma_t
        Tolerances, in the units of gamma and tau.

    Returns
    -------
    (...) in [0, 1], no unit
    """
    return np.exp(-((gamma / sigma_e) ** 2) - (tau / sigma_t) ** 2)


def similarity_matrix(
    points: Array,
    normals: Array,
    sigma_e: float = 5.0,
    sigma_t: float = 0.7,
    *,
    cutoff: float = 0.0,
    r_cap: float = np.inf,
    weights: Array | None = None,
) -> Array:
    """Phi of all pairs of points (Eqs. 4-7), one row after the other.

    Parameters
    ----------
    points, normals : (n, 3)
        The cloud and its outward unit normals.
    sigma_e, sigma_t
        Tolerances of Eq. 7.
    cutoff, r_cap, weights
        What the code adds to Eqs. 5 and 7, as in `medial.similarity.similarity.similarity`. The defaults are
        the paper.

    Returns
    -------
    (n, n)
        Symmetric, zero diagonal; 0 where two points have no candidate ball.
    """
    n = len(points)
    phi = np.zeros((n, n))
    for i in range(n):
        centers, radii = candidate_balls(points[i], points, normals[i], normals)
        j = np.flatnonzero((radii > 0) & (radii <= r_cap) & (np.arange(n) > i))
        balls = centers[j], radii[j]
        tau = normal_deviation(points[i], points[j], normals[i], normals[j], *balls)
        value = medial_similarity(summed_depth(*balls, points, weights), tau, sigma_e, sigma_t)
        phi[i, j] = np.where(value >= cutoff, value, 0)
    return phi + phi.T

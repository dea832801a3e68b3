r"""Eqs. 16 and 17 as the paper writes them: plain NumPy for small clouds, the reference of the search.

The fast forms are in `medial.matching.landmarks.diffusion_landmarks`. Points of the source are p in P, of the
target q in Q; T is the number of times.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def kernel_over_times(eigenvalues: Array, eigenfunctions: Array, times: Array, area: float = 1.0) -> Array:
    """m_o of Sec. 4: m_t (Eq. 13) between all points at all times, divided by the heat trace at t.

    In the code: m_t is multiplied by the cloud's own area, so that two clouds of different size or unit are
    compared as if both had area 1.

    Parameters
    ----------
    eigenvalues : (k,)
    eigenfunctions : (n, k)
        Orthonormal for the areas, in one over units.
    times : (T,)
        In the reciprocal unit of the eigenvalues.
    area
        1 in the paper; the total area of the cloud in the code.

    Returns
    -------
    (n, n, T), in one over squared units, or none with `area`
    """
    decay = np.exp(-np.multiply.outer(eigenvalues, times))
    decay /= decay.sum(axis=0)
    return area * np.einsum("xk,yk,kt->xyt", eigenfunctions, eigenfunctions, decay)


def landmark_cost(source: Array, target: Array, found: Array | None = None) -> float:
    """The sum that Eq. 16 minimises over q_l, for one candidate q_l.

    Parameters
    ----------
    source : (s, T)
        m_o(p_l, p) from the landmark to every sample p of the source.
    target : (m, T)
        m_o(q_l, q) from the candidate to every sample q of the target.
    found : (m, s), optional
        Squared distances between target and source samples in the coordinates of landmarks found before:
        appending coordinates adds up squares.

    Returns
    -------
    float
    """
    squares = ((target[:, None] - source) ** 2).sum(axis=2) + (0 if found is None else found)
    return float(np.sqrt(squares).min(axis=0).sum())


def landmark_partner(source: Array, targets: Array, found: Array | None = None) -> int:
    r"""Eq. 16: the candidate whose medial diffusion agrees best with that of a landmark p_l.

    .. math::

        \bar q_l = \underset{q_l \in S_Q}{\operatorname{argmin}} \sum_{p \in S_P}
        \min_{q \in S_Q} |m_o^P(p_l, p) - m_o^Q(q_l, q)|

    In the code: m_o is that of clouds of area 1 (`kernel_over_times`), in single precision; distances come
    from blocked matrix products instead of a kd-tree.

    Parameters
    ----------
    source : (s, T)
        m_o(p_l, p) from the landmark to every sample p of the source.
    targets : (c, m, T)
        m_o(q_l, q) from each candidate q_l to every sample q of the target. Sec. 4 takes the 5 % of the
        samples that are nearest to p_l in their signature m_o(q_l, q_l).
    found : (m, s), optional
        As in `landmark_cost`.

    Returns
    -------
    int
        Position of the partner among the candidates.
    """
    return int(np.argmin([landmark_cost(source, each, found) for each in targets]))


def extrapolated(
    source: Array, target: Array, source_signature: Array, target_signature: Array
) -> tuple[NDArray[np.intp], Array]:
    r"""Eq. 17: the target point of every source point, by agreement with the landmarks and in the signature.

    .. math::

        \bar q = \underset{q \in Q}{\operatorname{argmin}} \sum_{l=1}^{L} |m_o^P(p_l, p) - m_o^Q(q_l, q)|
        + |m_o^P(p, p) - m_o^Q(q, q)|

    In the code: as for Eq. 16, m_o is that of clouds of area 1 and in single precision.

    Parameters
    ----------
    source : (L, n, T)
        m_o(p_l, p) from each landmark of the source to every point.
    target : (L, m, T)
        m_o(q_l, q) from their partners to every point of the target.
    source_signature : (n, T)
    target_signature : (m, T)
        m_o(p, p) and m_o(q, q).

    Returns
    -------
    partners : (n,) int
        The minimising q for every p.
    costs : (n,)
        The minimum.
    """
    total = np.linalg.norm(source_signature[:, None] - target_signature, axis=2)
    for here, there in zip(source, target, strict=True):
        total += np.linalg.norm(here[:, None] - there, axis=2)
    return total.argmin(axis=1), total.min(axis=1)

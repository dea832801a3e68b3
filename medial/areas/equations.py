r"""Eqs. 1, 9 and 10 as the paper writes them: plain NumPy for small clouds, the reference of the kernels.

The fast forms are `medial.areas.dual_area.medial_axis` and `medial.areas.dual_area.dual_areas`.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from medial.similarity.equations import candidate_balls

Array = NDArray[np.float64]


def smoothed_density(distances: Array, areas: Array, sigma: float) -> float:
    r"""Eq. 1: the smoothed density of the surface at a medial point x, as a sum over the surface.

    .. math::

        |\tilde\Gamma(x)| = \int_S \exp\left(-\frac{d(z, \Pi_x(z))}{\sigma}\right) dz

    The surface area near the points Gamma(x) where the medial ball of x touches the surface. In the code:
    nothing computes it, because an integral over the surface (Eq. 3) holds it already.

    Parameters
    ----------
    distances : (n,)
        Geodesic distance of each surface point from the nearest point of Gamma(x).
    areas : (n,)
        Surface area that each point stands for, in squared units.
    sigma
        Width of the smoothing, in the units of the distances.

    Returns
    -------
    float, in squared units
    """
    return float(np.exp(-distances / sigma) @ areas)


def medial_averages(points: Array, normals: Array, phi: Array) -> tuple[Array, Array]:
    r"""Eq. 9: medial point and radius of every point, averages of its candidate balls weighted by phi.

    .. math::

        \hat p_i = \frac{\sum_j c_{ij}\, \phi(p_i, p_j)}{\sum_j \phi(p_i, p_j)},
        \qquad r_i = \frac{\sum_j r_{ij}\, \phi(p_i, p_j)}{\sum_j \phi(p_i, p_j)}

    In the code: a point without any similar point, for which the average is 0 / 0, takes the radius of the
    nearest point that has one (`medial.areas.dual_area.medial_axis`).

    Parameters
    ----------
    points, normals : (n, 3)
        The cloud and its outward unit normals.
    phi : (n, n)
        Medial similarity (Eq. 7).

    Returns
    -------
    centers : (n, 3)
    radii : (n,)
        NaN for points without any similar point.
    """
    centers, radii = np.full(points.shape, np.nan), np.full(len(points), np.nan)
    for i in range(len(points)):
        total = phi[i].sum()
        if total > 0:
            ball_centers, ball_radii = candidate_balls(points[i], points, normals[i], normals)
            centers[i], radii[i] = phi[i] @ ball_centers / total, phi[i] @ ball_radii / total
    return centers, radii


def average_distance(points: Array) -> float:
    """Average sampling distance: the mean distance of a point from the nearest other one."""
    distances = np.linalg.norm(points[:, None] - points, axis=2)
    np.fill_diagonal(distances, np.inf)
    return float(distances.min(axis=1).mean())


def medial_neighbourhood(i: int, centers: Array, epsilon: float) -> NDArray[np.intp]:
    r"""Eq. 10: B_i, the points whose medial points are within epsilon of that of point i.

    .. math::

        B_i = \{ p_j \in P \mid |\hat p_i - \hat p_j| < \varepsilon \}

    In the code: the twelve points nearest to point i join B_i. Without them, a point whose neighbours on the
    surface happen to have other medial points gets triangles that span half the body.

    Parameters
    ----------
    i
        The point.
    centers : (n, 3)
        Medial points (Eq. 9).
    epsilon
        1.5 times the average sampling distance.

    Returns
    -------
    (members,) int
        Ascending, point i among them.
    """
    return np.flatnonzero(np.linalg.norm(centers - centers[i], axis=1) < epsilon)


def dual_area(i: int, members: NDArray[np.intp], points: Array, center: Array, radius: float) -> float:
    """Dual area of point i: a third of the triangles at it of the convex hull of B_i (after Eq. 10).

    Where the point is not a corner of that hull, all members are projected to its medial ball first.

    In the code: the same without Qhull (`medial.areas.hull_triangles`). Afterwards all areas are scaled so
    that their median ratio to the cells of the surface is 1, because the hulls fall short by a share that
    depends on the number of points.

    Parameters
    ----------
    i
        The point.
    members : (m,) int
        B_i with point i (`medial_neighbourhood`).
    points : (n, 3)
        The cloud.
    center : (3,)
    radius
        Medial ball of point i (Eq. 9).

    Returns
    -------
    float, in squared units
        NaN where neither hull has the point as a corner, or the point has no medial point and so no B_i;
        the code takes its surface cell then.
    """
    if i not in members:
        return np.nan
    own = int(np.flatnonzero(members == i)[0])
    offsets = points[members] - center
    on_ball = center + radius * offsets / np.linalg.norm(offsets, axis=1, keepdims=True)
    for corners in (points[members], on_ball):
        area = incident_area(corners, own)
        if np.isfinite(area):
            return area / 3
    return np.nan


def incident_area(points: Array, own: int) -> float:
    """Area of the triangles of the convex hull of (m, 3) points at one of them; NaN if it is no corner."""
    if len(points) < 4:
        return np.nan
    try:
        triangles = ConvexHull(points).simplices
    except QhullError:  # all in one plane
        return np.nan
    a, b, c = (points[triangles[(triangles == own).any(axis=1)][:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2) if len(a) else np.nan

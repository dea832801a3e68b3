"""The paper's formulas as slowly and plainly as possible: what the fast versions are compared with."""

import numpy as np
from scipy.spatial import ConvexHull, QhullError


def candidate_ball(p, q, n, m):
    """Centre, radius and F of the ball of two oriented points; None where there is none."""
    d = p - q
    square, a, b = d @ d, n @ d, m @ d
    if square == 0 or a <= b:
        return None
    tangency = np.sqrt(max(2 + 2 * n @ m - 4 * a * b / square, 0))
    g, k = square / (2 * (a - b)), 2 * b / square
    return p - g * (n + m - k * d), g * tangency, tangency


def tau(p, q, n, m, center, radius):
    """Eq. 4, from the normals of the ball themselves."""
    return np.linalg.norm(n - (p - center) / radius) + np.linalg.norm(m - (q - center) / radius)


def similarity(points, normals, sigma_e=5.0, sigma_t=0.7, cutoff=1e-6, cap=None, weights=None):
    """Eqs. 4-7 over all pairs, dense."""
    n = len(points)
    weights = np.ones(n) if weights is None else weights
    if cap is None:
        centred = points - points.mean(axis=0)
        cap = np.ptp(centred @ np.linalg.svd(centred, full_matrices=False)[2].T, axis=0).min()
    phi = np.zeros((n, n))
    for i in range(n):
        j = np.arange(i + 1, n)
        d = points[i] - points[j]
        square, a, b = (d * d).sum(axis=1), d @ normals[i], (d * normals[j]).sum(axis=1)
        j, d, square, a, b = (x[(a > b) & (square > 0)] for x in (j, d, square, a, b))
        tangency = np.sqrt(np.maximum(2 + 2 * normals[j] @ normals[i] - 4 * a * b / square, 0))
        g, k = square / (2 * (a - b)), 2 * b / square
        center = points[i] - g[:, None] * (normals[i] + normals[j] - k[:, None] * d)
        radius = g * tangency
        good = (radius <= cap) & (tangency > 1e-6)
        j, center, radius, tangency = (x[good] for x in (j, center, radius, tangency))
        depth = ((center[:, None] - points) ** 2).sum(axis=2) / (radius**2)[:, None]
        gamma = np.maximum(1 - depth**2, 0) @ weights
        value = np.exp(-((gamma / sigma_e) ** 2) - 4 * (2 - tangency) / sigma_t**2)
        phi[i, j] = np.where(value >= cutoff, value, 0)
    return phi + phi.T


def medial_axis(points, normals, phi):
    """Eq. 9."""
    centers, radii = np.zeros_like(points), np.zeros(len(points))
    for i in range(len(points)):
        balls = [
            (phi[i, j], candidate_ball(points[i], points[j], normals[i], normals[j]))
            for j in np.flatnonzero(phi[i])
        ]
        total = sum(weight for weight, _ in balls)
        if total > 0:
            centers[i] = sum(weight * ball[0] for weight, ball in balls) / total
            radii[i] = sum(weight * ball[1] for weight, ball in balls) / total
    return centers, radii


def dual_areas(points, centers, radii, epsilon):
    """Eq. 10 and the hulls after it, by Qhull; NaN where there is no hull."""
    areas = np.full(len(points), np.nan)
    for i in range(len(points)):
        members = np.flatnonzero(np.linalg.norm(centers - centers[i], axis=1) < epsilon)
        own = int(np.flatnonzero(members == i)[0])
        offsets = points[members] - centers[i]
        on_ball = centers[i] + radii[i] * offsets / np.linalg.norm(offsets, axis=1, keepdims=True)
        for cloud in (points[members], on_ball):
            area = fan_area(cloud, own)
            if np.isfinite(area):
                areas[i] = area / 3
                break
    return areas


def fan_area(cloud, own):
    """Area of the hull triangles at one of the points; NaN if it is not a corner of the hull."""
    if len(cloud) < 4:
        return np.nan
    try:
        hull = ConvexHull(cloud)
    except QhullError:
        return np.nan
    corners = cloud[hull.simplices[(hull.simplices == own).any(axis=1)]]
    if not len(corners):
        return np.nan
    return (
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
        / 2
    )


def combined(phi, alpha, areas, eta):
    """Eqs. 14-15, dense."""
    total = np.zeros_like(phi)
    for share, weights in ((1 - eta, phi), (eta, alpha)):
        degree = (weights - np.diag(np.diag(weights))) @ areas
        root = np.sqrt(np.where(degree > 0, degree, np.inf))
        total += share * weights / root[:, None] / root[None, :]
    return total

"""Pairs of points with normals: how well they meet, and who is nearest; compiled."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.compiled import compiled

Float = NDArray[np.float64]
Int = NDArray[np.int64]

FEW = 1000
"""Up to this number, places are compared one by one; of more, a tree finds the nearest."""


@compiled()
def meeting(points: Float, normals: Float, goals: Float, goal_normals: Float) -> tuple[Float, Float]:
    """Squared distances of points from their goals, and cosines of their normals, not below 0; (n,) each."""
    square, cosine = np.zeros(len(points)), np.zeros(len(points))
    for i in range(len(points)):
        dot = 0.0
        for r in range(3):
            square[i] += (points[i, r] - goals[i, r]) ** 2
            dot += normals[i, r] * goal_normals[i, r]
        cosine[i] = min(1.0, max(0.0, dot))
    return square, cosine


@compiled()
def nearest_of_few(places: Float, goals: Float) -> Int:
    """Index of the place nearest to each goal, (g,); of equally near ones the first.

    Compares all pairs: for some hundred places faster than making a tree. The innermost loop runs over the
    goals, side by side.

    Parameters
    ----------
    places : (p, 6)
    goals : (g, 6)
    """
    a, b, c, d, e, f = [np.ascontiguousarray(goals[:, k]) for k in range(6)]
    index, least = np.zeros(len(goals), np.int64), np.full(len(goals), np.inf)
    for i in range(len(places)):
        u, v, w, x, y, z = places[i]
        for j in range(len(goals)):
            square = (a[j] - u) ** 2 + (b[j] - v) ** 2 + (c[j] - w) ** 2
            square += (d[j] - x) ** 2 + (e[j] - y) ** 2 + (f[j] - z) ** 2
            nearer = square < least[j]
            least[j] = square if nearer else least[j]
            index[j] = i if nearer else index[j]
    return index


def nearest_places(places: Float, goals: Float) -> Int:
    """Index of the place nearest to each goal, (g,), where places (p, 6) are looked among but once."""
    if len(places) <= FEW:
        return np.asarray(nearest_of_few(places, goals))
    return np.asarray(cKDTree(places).query(goals)[1])

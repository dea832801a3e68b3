r"""What is computed for the cutting plane of one point, as written in [TZCO09], and slowly.

The plane through a point p with the unit normal v holds the points N(v) within a distance of it that are
joined to p by neighbours within that distance. Their normals n_j give

* the direction:  v <- argmin over unit v of  var { <v, n_j> : j in N(v) },
* the centre:     x = argmin of  sum over j in N(v) of  \| (x - p_j) x n_j \|^2.

`medial.skeletons.cutting_planes` computes the same of all points at once.
"""

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
Int = NDArray[np.int64]


def plane_points(points: Float, pairs: Int, point: int, direction: Float, thickness: float) -> Int:
    """Ids of the points N(v) of the plane through a point, ascending.

    Parameters
    ----------
    points : (n, 3)
    pairs : (E, 2)
        Neighbours.
    point
        Id of p.
    direction : (3,)
        v.
    thickness
        Largest distance from the plane.
    """
    within = np.abs((points - points[point]) @ direction) <= thickness
    found, waiting = {point}, [point]
    while waiting:
        here = waiting.pop()
        around = np.concatenate([pairs[pairs[:, 0] == here, 1], pairs[pairs[:, 1] == here, 0]])
        new = [int(j) for j in around if within[j] and int(j) not in found]
        found.update(new)
        waiting += new
    return np.array(sorted(found), dtype=np.int64)


def variance(direction: Float, normals: Float) -> float:
    """Variance of the normals (m, 3) along a direction (3,)."""
    return float(np.var(normals @ direction))


def least_variance_direction(normals: Float) -> Float:
    """Unit direction (3,) along which normals (m, 3) vary least: the last eigenvector of their covariance."""
    return np.asarray(np.linalg.eigh(np.cov(normals.T, bias=True))[1][:, 0])


def symmetric_center(points: Float, normals: Float) -> Float:
    """The place (3,) nearest to the lines through points (m, 3) along normals (m, 3), in least squares.

    Each line gives three equations, (x - p) x n = 0: row d has the components of e_i x n along d.
    """
    rows = np.concatenate([np.cross(np.eye(3), normal).T for normal in normals])
    sides = np.concatenate([np.cross(point, normal) for point, normal in zip(points, normals, strict=True)])
    return np.asarray(np.linalg.lstsq(rows, sides, rcond=None)[0])

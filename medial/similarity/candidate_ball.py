r"""The candidate ball of two oriented points (Eqs. 4-5), and the depth of a point in it (Eq. 6).

The ball through p_i and p_j, centred on their bisector plane, whose outward sphere normals agree best with
n_i and n_j in least squares. With d = p_i - p_j, D = |d|^2, a_i = n_i.d, a_j = n_j.d::

    F   = sqrt(2 + 2 n_i.n_j - 4 a_i a_j / D)     in [0, 2]; 2 is perfectly tangent
    g   = D / (2 (a_i - a_j)),  k = 2 a_j / D
    c   = p_i - g (n_i + n_j - k d),  r = g F
    tau = 2 sqrt(2 - F)                            both terms of Eq. 4 are equal

No ball inside the shape touches both points when a_i <= a_j; F near 0 means that the normals oppose it.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled

SMALLEST_TANGENCY = 1e-6  # F below this: the normals oppose every ball through the two points


@compiled(inline="always")
def candidate_ball(px: Any, py: Any, pz: Any, nx: Any, ny: Any, nz: Any, i: int, j: int) -> Any:
    """Centre, radius and tangency of the candidate ball of points i and j, all in the dtype of the arrays.

    Returns
    -------
    cx, cy, cz, r, F
        r = 0 where there is no ball.
    """
    dx, dy, dz = px[i] - px[j], py[i] - py[j], pz[i] - pz[j]
    square = dx * dx + dy * dy + dz * dz
    ai = nx[i] * dx + ny[i] * dy + nz[i] * dz
    aj = nx[j] * dx + ny[j] * dy + nz[j] * dz
    zero = square * 0
    if square == 0 or ai <= aj:
        return zero, zero, zero, zero, zero
    dot = nx[i] * nx[j] + ny[i] * ny[j] + nz[i] * nz[j]
    tangency_squared = 2 + 2 * dot - 4 * ai * aj / square
    if tangency_squared <= SMALLEST_TANGENCY * SMALLEST_TANGENCY:
        return zero, zero, zero, zero, zero
    tangency = np.sqrt(tangency_squared)
    g = square / (2 * (ai - aj))
    k = 2 * aj / square
    cx = px[i] - g * (nx[i] + nx[j] - k * dx)
    cy = py[i] - g * (ny[i] + ny[j] - k * dy)
    cz = pz[i] - g * (nz[i] + nz[j] - k * dz)
    return cx, cy, cz, g * tangency, tangency


def columns(points: NDArray[np.floating], dtype: type = np.float64) -> tuple[NDArray[Any], ...]:
    """The coordinates as three contiguous arrays: what the kernels read."""
    return tuple(np.ascontiguousarray(points[:, axis], dtype=dtype) for axis in range(3))


def smallest_width(points: NDArray[np.floating]) -> float:
    """The extent of the cloud along its narrowest principal axis.

    Twice the largest radius a ball inside a complete shape can have, so the default cap on candidate radii.
    """
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    return float(np.ptp(centred @ axes, axis=0).min())

"""Points that follow a blend of their nodes' rigid motions [SSP07], compiled."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled

Float = NDArray[np.float64]
Int = NDArray[np.int64]


@compiled()
def blend(
    points: Float, directions: Float, nodes: Int, weights: Float, rest: Float, turn: Float, place: Float
) -> tuple[Float, Float]:
    """Positions and unit directions of points that follow their nodes.

    Parameters
    ----------
    points, directions : (n, 3)
        At rest.
    nodes, weights : (n, influences)
        The nodes of each point and their weights.
    rest : (N, 3)
        Nodes at rest.
    turn, place : (N, 3, 3), (N, 3)
        Rotations and positions of the nodes.

    Returns
    -------
    (n, 3) float64, (n, 3) float64
    """
    n, influences = nodes.shape
    here, normal = np.zeros((n, 3)), np.zeros((n, 3))
    for i in range(n):
        for k in range(influences):
            j, w = nodes[i, k], weights[i, k]
            for r in range(3):
                x, v = place[j, r], 0.0
                for c in range(3):
                    x += turn[j, r, c] * (points[i, c] - rest[j, c])
                    v += turn[j, r, c] * directions[i, c]
                here[i, r] += w * x
                normal[i, r] += w * v
        length = np.sqrt(normal[i, 0] ** 2 + normal[i, 1] ** 2 + normal[i, 2] ** 2) + 1e-12
        for r in range(3):
            normal[i, r] /= length
    return here, normal

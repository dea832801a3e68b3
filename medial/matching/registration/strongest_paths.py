"""Paths between nodes whose weakest edge is as strong as possible; compiled."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled

Float = NDArray[np.float64]
Int = NDArray[np.int64]


@compiled()
def strongest_paths(count: int, edges: Int, strength: Float) -> Float:
    """Strength of the best path between any two nodes, (N, N): that of its weakest edge; 1 to itself.

    Trees grow by edges, the strongest first: the one that joins two of them is the weakest on the best path
    from any node of the one to any of the other.

    Parameters
    ----------
    count
        N.
    edges : (E, 2)
    strength : (E,)
        In [0, 1].
    """
    best, tree = np.zeros((count, count)), np.arange(count)
    for k in range(count):
        best[k, k] = 1.0
    for e in np.argsort(-strength):
        here, there = tree[edges[e, 0]], tree[edges[e, 1]]
        if here == there:
            continue
        first, second = np.flatnonzero(tree == here), np.flatnonzero(tree == there)
        for i in first:
            for j in second:
                best[i, j] = best[j, i] = strength[e]
        tree[second] = here
    return best

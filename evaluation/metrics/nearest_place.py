"""The parts of `SurfaceDistance.to_nearest`: distances from a set of surface points, all at once.

Both ends of a way are as in a search between two points: straight lines from a point to the vertices that it
sees, and the graph of `evaluation.metrics.geodesic` between those.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from datasets_gen.compiled import compiled
from evaluation.metrics.unfolding import ENTRY_DEPTH, REACHED, Floats, Ints, enter


@compiled()
def straight_lines(
    vertices: Floats, faces: Ints, neighbour: Ints, opposite: Ints, face_ids: Ints, barycentrics: Floats
) -> tuple[Ints, Ints, Floats]:
    """Straight lines from points to the vertices that they see.

    Returns
    -------
    start : (n + 1,) int64
        Where each point's lines begin among all; every point has some.
    vertex : (lines,) int64
    length : (lines,) float64
    """
    n = len(face_ids)
    start, ids, lengths = np.zeros(n + 1, np.int64), np.empty(n * REACHED, np.int64), np.empty(n * REACHED)
    nowhere = np.zeros(3)
    for i in range(n):
        k = start[i]
        used, _ = enter(
            vertices,
            faces,
            neighbour,
            opposite,
            face_ids[i],
            barycentrics[i],
            -1,
            nowhere,
            ids[k:],
            lengths[k:],
        )
        start[i + 1] = k + used
    return start, ids[: start[n]].copy(), lengths[: start[n]].copy()


def onward(graph: csr_array, least: NDArray[np.float64]) -> NDArray[np.float64]:
    """Length of the shortest way from each vertex through the graph and on, (v,).

    Parameters
    ----------
    graph : (v, v)
        Symmetric.
    least : (v,)
        Length of the shortest straight line from each vertex to a point of the set; infinite: none.
    """
    v = len(least)
    reached = np.flatnonzero(np.isfinite(least))
    joined = csr_array(
        (
            np.concatenate([graph.data, least[reached]]),
            np.concatenate([graph.indices, reached]),
            np.concatenate([graph.indptr, [graph.nnz + len(reached)]]),
        ),
        shape=(v + 1, v + 1),
    )
    return np.asarray(dijkstra(joined, indices=v)[:v])


def in_sight(
    neighbour: NDArray[np.int32], face_ids: NDArray[np.int64], other_face_ids: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs of points that a straight line may join: at most `ENTRY_DEPTH` edges lie between their faces.

    Parameters
    ----------
    neighbour : (f, 3)
        Of `face_adjacency`.
    face_ids : (n,), other_face_ids : (m,)

    Returns
    -------
    i, j : (pairs,) int64
    """
    f = len(neighbour)
    rows, columns = np.nonzero(neighbour >= 0)
    stay = np.arange(f)
    ends = np.concatenate([rows, stay]), np.concatenate([neighbour[rows, columns], stay])
    step = csr_array((np.ones(len(ends[0]), dtype=np.float32), ends), shape=(f, f))
    around = _at(face_ids, f)
    for _ in range(ENTRY_DEPTH):
        around = around @ step
    i, j = (around @ _at(other_face_ids, f).T).nonzero()
    return i.astype(np.int64), j.astype(np.int64)


def _at(face_ids: NDArray[np.int64], f: int) -> csr_array:
    """Which face each point lies on, (n, f)."""
    n = len(face_ids)
    return csr_array((np.ones(n, dtype=np.float32), face_ids, np.arange(n + 1)), shape=(n, f))

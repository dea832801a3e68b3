"""Boundaries of meshes: edges of one face, and the rims that they make."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from datasets_gen.meshes.geometry import directed_edges

Ints = NDArray[np.int64]


def boundary_rims(faces: NDArray[np.integer]) -> tuple[Ints, Ints]:
    """Edges of one face, and which of them hang together.

    Parameters
    ----------
    faces : (f, 3)

    Returns
    -------
    edges : (e, 2)
        In the direction of their faces; none of a closed mesh.
    rims : (e,)
        Number of the connected boundary of each edge, from 0.
    """
    edges = directed_edges(faces)
    _, index, counts = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    rim = edges[counts[index.ravel()] == 1]
    names, ends = np.unique(rim, return_inverse=True)
    ends = ends.reshape(-1, 2)
    graph = coo_array((np.ones(len(rim), dtype=np.int8), (ends[:, 0], ends[:, 1])), shape=(len(names),) * 2)
    label = connected_components(graph, directed=False)[1] if len(rim) else np.zeros(0)
    return rim, label[ends[:, 0]].astype(np.int64)


def boundary_loops(faces: NDArray[np.integer]) -> list[int]:
    """Number of edges of each connected boundary of faces (f, 3); empty for a closed mesh."""
    return np.bincount(boundary_rims(faces)[1]).tolist()

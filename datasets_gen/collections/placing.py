"""Meshes of their own placed on the reference by a map of some of their vertices."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from datasets_gen.mesh_placement import MeshPlacement
from datasets_gen.meshes.geometry import undirected_edges
from datasets_gen.records import InputError
from datasets_gen.shape import Shape


def placed_by_ids(shape: Shape, ids: NDArray[np.integer], reference: Shape) -> tuple[MeshPlacement, int]:
    """The placement by vertices of the reference, and how many vertices had none of their own.

    Parameters
    ----------
    shape
    ids : (v,)
        Vertex of the reference of each vertex of the shape; -1 for none, which takes that of the nearest
        vertex, along the mesh, that has one.
    reference

    Raises
    ------
    InputError
        If no vertex of the shape, or of a piece of it, has one.
    """
    return MeshPlacement.of_vertices(spread(shape, ids), reference), int((np.asarray(ids) < 0).sum())


def spread(shape: Shape, ids: NDArray[np.integer]) -> NDArray[np.int64]:
    """Ids (v,) with every -1 replaced by that of the nearest vertex along the mesh that has one.

    Raises
    ------
    InputError
        If there is none.
    """
    found = np.asarray(ids, dtype=np.int64)
    known = np.flatnonzero(found >= 0)
    if len(known) == len(found):
        return found
    lost = f"no vertex of {shape.name!r}, or of a piece of it, has a place on the reference; check its map"
    if not len(known):
        raise InputError(lost)
    edges = undirected_edges(shape.faces)[0]
    lengths = np.linalg.norm(shape.vertices[edges[:, 0]] - shape.vertices[edges[:, 1]], axis=1)
    lengths = np.maximum(lengths, np.finfo(float).tiny)  # an explicit zero is no edge
    graph = csr_array((lengths, (edges[:, 0], edges[:, 1])), shape=(len(found),) * 2)
    _, _, sources = dijkstra(graph, directed=False, indices=known, min_only=True, return_predecessors=True)
    if (sources < 0).any():
        raise InputError(lost)
    return found[sources]

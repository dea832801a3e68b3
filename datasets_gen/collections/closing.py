"""Meshes of other programs made closed: seams welded, crowded edges cut out, small holes filled."""

import itertools
import logging
from collections.abc import Set

import numpy as np
from numpy.typing import NDArray

from datasets_gen.checks import edge_face_counts, face_components, repeated_corners
from datasets_gen.meshes.geometry import directed_edges, first_at_places
from datasets_gen.records import InputError

_log = logging.getLogger(__name__)

Ints = NDArray[np.int64]


def weld(vertices: NDArray[np.floating], faces: NDArray[np.integer]) -> tuple[Ints, Ints]:
    """Join vertices at one place, as along the seams of a texture.

    Parameters
    ----------
    vertices : (v, 3)
    faces : (f, 3)

    Returns
    -------
    kept : (w,)
        The first of the vertices at each place, in their order.
    faces : (f, 3)
        Of `kept`, without those that name a vertex twice.
    """
    kept, place = first_at_places(vertices)
    joined = place[faces]
    return kept, joined[~repeated_corners(joined)]


def uncrowded(faces: Ints) -> Ints:
    """Faces (f, 3) without those at the vertices of edges that have more than two faces."""
    edges = np.sort(directed_edges(faces), axis=1)
    unique, counts = np.unique(edges, axis=0, return_counts=True)
    crowded = np.unique(unique[counts > 2])
    return faces[~np.isin(faces, crowded).any(axis=1)]


def close(vertices: NDArray[np.floating], faces: Ints, name: str) -> tuple[Ints, Ints]:
    """The largest component as a closed manifold.

    Vertices at edges of more than two faces are taken away with their faces, then the holes are filled.

    Parameters
    ----------
    vertices : (v, 3)
    faces : (f, 3)
    name
        For the log.

    Returns
    -------
    kept : (w,)
        Vertices that are left.
    faces : (f, 3)
        Of `kept`.

    Raises
    ------
    InputError
        If the mesh cannot be closed in this way.
    """
    sound = uncrowded(faces)
    labels = face_components(sound)
    largest = sound[labels == np.bincount(labels).argmax()]
    kept, compact = np.unique(largest, return_inverse=True)
    closed = fill_holes(vertices[kept], compact.reshape(-1, 3))
    if (edge_face_counts(closed) != 2).any():
        raise InputError(f"the mesh of {name!r} cannot be closed; install the package with its files again")
    filled = len(closed) - len(largest)
    if len(kept) < len(vertices) or filled:
        _log.info(
            "%s: %d vertices left out (crowded edges or small parts), holes filled with %d faces",
            name, len(vertices) - len(kept), filled,
        )  # fmt: skip
    return kept, closed


def fill_holes(vertices: NDArray[np.floating], faces: Ints) -> Ints:
    """Faces (f, 3) of vertices (v, 3) and those that fill their holes, each by a fan from its rim.

    The fan of the shortest edges is taken that uses no edge that is there. Good for holes that are small and
    about round. No vertex is added, so that ground truth by the order of the vertices stays exact in every
    pose.

    Raises
    ------
    InputError
        If no fan fits, or two holes meet at a vertex.
    """
    edges = directed_edges(faces)
    known = set(map(tuple, edges.tolist()))
    following = {b: a for a, b in known if (b, a) not in known}  # along the rim, as new faces see it
    if len(following) < sum((b, a) not in known for a, b in known):
        raise InputError("two holes of the mesh meet at a vertex; it cannot be closed")
    added = []
    while following:
        start, after = following.popitem()
        rim = [start]
        while after != start:
            rim.append(after)
            after = following.pop(after)
        added += _fan(vertices, rim, known)
    return np.concatenate([faces, np.array(added, dtype=np.int64).reshape(-1, 3)])


def _fan(
    vertices: NDArray[np.floating], rim: list[int], known: Set[tuple[int, int]]
) -> list[tuple[int, int, int]]:
    """Triangles that fill a rim, from the vertex with the shortest new edges."""
    best: tuple[float, list[int]] | None = None
    for k, hub in enumerate(rim):
        turned = rim[k:] + rim[:k]
        inner = turned[2:-1]
        if any((hub, other) in known or (other, hub) in known for other in inner):
            continue
        length = float(np.linalg.norm(vertices[inner] - vertices[hub], axis=1).sum())
        if best is None or length < best[0]:
            best = length, turned
    if best is None:
        raise InputError(f"a hole with a rim of {len(rim)} edges cannot be filled")
    hub, *others = best[1]
    return [(hub, a, b) for a, b in itertools.pairwise(others)]

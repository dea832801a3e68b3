"""Isotropic remeshing of an implicit surface with a prescribed edge length [BK04].

Rounds of splits, collapses, flips and tangential smoothing, each a batch of operations on edges far enough
apart not to touch the same faces, followed by projection onto the surface. A boundary may only lie in the
plane x = 0, where half a mirror-symmetric body ends; its vertices stay in that plane.

gpytoolbox and pymeshlab take one edge length for the whole mesh. On half of the human they leave slivers
(0.1 and 0.2 degrees; here 21), vertices 6 mm off the surface (here 0.3), and a rim that is fixed or leaves
the plane: ``python -m tests.benchmarks.remeshing``.

[BK04] M. Botsch, L. Kobbelt, "A remeshing approach to multiresolution modeling", SGP 2004.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from datasets_gen.meshes.geometry import scaled_face_normals, vertex_normals

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Sizing = Callable[[Array], Array]
Projection = Callable[[Array, NDArray[np.bool_]], Array]

LONG, SHORT = 4 / 3, 4 / 5  # of the wanted length, [BK04]
MIN_TURN = 0.2  # smallest cosine by which an operation may turn a face


class Edges:
    """The edges of a manifold mesh with their faces.

    Attributes
    ----------
    ends : (e, 2) int
        Vertices, the smaller id first.
    faces : (e, 2) int
        The one or two faces; -1 for none.
    opposite : (e, 2) int
        Vertex of each of these faces that is not on the edge; -1 for none.
    """

    def __init__(self, faces: Ints) -> None:
        directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        owner = np.tile(np.arange(len(faces)), 3)
        across = np.concatenate([faces[:, 2], faces[:, 0], faces[:, 1]])
        low, high = directed.min(axis=1), directed.max(axis=1)
        order = np.lexsort((directed[:, 0] > directed[:, 1], high, low))
        low, high, owner, across = low[order], high[order], owner[order], across[order]
        first = np.concatenate([[True], (low[1:] != low[:-1]) | (high[1:] != high[:-1])])
        index = np.flatnonzero(first)
        paired = np.append(index[1:], len(low)) - index == 2
        self.ends = np.stack([low[index], high[index]], axis=1)
        self.faces = np.full((len(index), 2), -1)
        self.opposite = np.full((len(index), 2), -1)
        self.faces[:, 0], self.opposite[:, 0] = owner[index], across[index]
        self.faces[paired, 1], self.opposite[paired, 1] = owner[index[paired] + 1], across[index[paired] + 1]

    @property
    def boundary(self) -> NDArray[np.bool_]:
        """Which edges have one face, (e,)."""
        return self.faces[:, 1] < 0

    def boundary_vertices(self, count: int) -> NDArray[np.bool_]:
        """Which of `count` vertices lie on the boundary."""
        on = np.zeros(count, dtype=bool)
        on[self.ends[self.boundary]] = True
        return on


def remesh(
    vertices: Array, faces: Ints, sizing: Sizing, project: Projection, rounds: int
) -> tuple[Array, Ints]:
    """Remesh towards well-shaped triangles with edges of the wanted length.

    Parameters
    ----------
    vertices : (v, 3), faces : (f, 3)
        A manifold mesh near the surface; a boundary only at x = 0.
    sizing
        Wanted edge length at points (n, 3).
    project
        Moves points (n, 3) onto the surface; the flags (n,) mark those that must stay at x = 0.
    rounds
        Of split, collapse, flip, smooth and project.

    Returns
    -------
    vertices (v', 3), faces (f', 3)
    """
    for _ in range(rounds):
        vertices, faces = _split(vertices, faces, sizing)
        for _ in range(12):
            vertices, faces, done = _collapse(vertices, faces, sizing)
            if done < 0.002 * len(faces):
                break
        for _ in range(2):
            faces = _flip(vertices, faces)
        vertices = _smooth(vertices, faces, sizing, project)
    return vertices, faces


def compact(vertices: Array, faces: Ints) -> tuple[Array, Ints]:
    """Drop vertices that no face uses."""
    used, inverse = np.unique(faces, return_inverse=True)
    return vertices[used], inverse.reshape(-1, 3)


def _turned(before: Array, after: Array) -> NDArray[np.bool_]:
    """Which normals turn by more than `MIN_TURN` allows."""
    scale = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    return np.einsum("nd,nd->n", before, after) < MIN_TURN * scale


def _ratio(vertices: Array, ends: Ints, sizing: Sizing) -> Array:
    a, b = vertices[ends[:, 0]], vertices[ends[:, 1]]
    return np.linalg.norm(a - b, axis=1) / sizing((a + b) / 2)


def _first_over(groups: Ints, rank: Ints, count: int) -> Ints:
    """Lowest rank in each of `count` groups; `groups` (n, k) lists the groups of each rank (n,)."""
    lowest = np.full(count, np.iinfo(np.int64).max)
    for column in groups.T:
        valid = column >= 0
        np.minimum.at(lowest, column[valid], rank[valid])
    return lowest


def _split(vertices: Array, faces: Ints, sizing: Sizing) -> tuple[Array, Ints]:
    edges = Edges(faces)
    ratio = _ratio(vertices, edges.ends, sizing)
    chosen = np.flatnonzero(ratio > LONG)
    rank = _ranks(-ratio[chosen])
    lowest = _first_over(edges.faces[chosen], rank, len(faces))
    pair = edges.faces[chosen]
    free = (lowest[pair[:, 0]] == rank) & ((pair[:, 1] < 0) | (lowest[pair[:, 1]] == rank))
    chosen = chosen[free]
    middle = len(vertices) + np.arange(len(chosen))
    vertices = np.concatenate([vertices, vertices[edges.ends[chosen]].mean(axis=1)])
    added, faces = [], faces.copy()
    for k in range(2):
        face = edges.faces[chosen, k]
        face, new, (u, v) = face[face >= 0], middle[face >= 0], edges.ends[chosen[face >= 0]].T
        other = faces[face].copy()
        other[other == u[:, None]] = np.repeat(new, (other == u[:, None]).sum(axis=1))
        first = faces[face].copy()
        first[first == v[:, None]] = np.repeat(new, (first == v[:, None]).sum(axis=1))
        faces[face] = first
        added.append(other)
    return vertices, np.concatenate([faces, *added])


def _collapse(vertices: Array, faces: Ints, sizing: Sizing) -> tuple[Array, Ints, int]:
    edges = Edges(faces)
    rim = edges.boundary_vertices(len(vertices))
    chosen = _independent_short_edges(vertices, faces, edges, rim, sizing)
    keep, drop = edges.ends[chosen].T
    swap = rim[drop] & ~rim[keep]
    keep, drop = np.where(swap, drop, keep), np.where(swap, keep, drop)
    middle = (vertices[keep] + vertices[drop]) / 2
    target = np.where((rim[keep] & ~rim[drop])[:, None], vertices[keep], middle)
    moved = vertices.copy()
    moved[keep] = moved[drop] = target
    edge_of = np.full(len(vertices), -1)
    edge_of[keep] = edge_of[drop] = np.arange(len(chosen))
    touching = edge_of[faces].max(axis=1)  # at most one chosen edge touches a face
    lost = (edge_of[faces] >= 0).sum(axis=1) == 2
    ring = np.flatnonzero((touching >= 0) & ~lost)
    turned = _turned(scaled_face_normals(vertices, faces[ring]), scaled_face_normals(moved, faces[ring]))
    good = np.ones(len(chosen), dtype=bool)
    good[touching[ring[turned]]] = False
    rename = np.arange(len(vertices))
    rename[drop[good]] = keep[good]
    result = vertices.copy()
    result[keep[good]] = target[good]
    remaining = ~lost
    remaining[lost] = ~good[touching[lost]]
    return (*compact(result, rename[faces[remaining]]), int(good.sum()))


def _independent_short_edges(
    vertices: Array, faces: Ints, edges: Edges, rim: NDArray[np.bool_], sizing: Sizing
) -> Ints:
    """Edges to collapse: short, without harm to the topology, and with no face touching two of them."""
    ratio = _ratio(vertices, edges.ends, sizing)
    crosses = rim[edges.ends].all(axis=1) & ~edges.boundary
    chosen = np.flatnonzero((ratio < SHORT) & ~crosses)
    chosen = chosen[_link_condition(edges, chosen, len(vertices))]
    rank = _ranks(ratio[chosen])
    lowest = _first_over(edges.ends[chosen], rank, len(vertices))
    of_face = lowest[faces].min(axis=1)
    within = np.full(len(vertices), np.iinfo(np.int64).max)  # lowest rank at a vertex and its neighbours
    for k in range(3):
        np.minimum.at(within, faces[:, k], of_face)
    return chosen[(within[edges.ends[chosen]] == rank[:, None]).all(axis=1)]


def _ranks(values: Array) -> Ints:
    """Position of each value in ascending order, ties in the order given."""
    rank = np.empty(len(values), dtype=np.int64)
    rank[np.argsort(values, kind="stable")] = np.arange(len(values))
    return rank


def _link_condition(edges: Edges, chosen: Ints, count: int) -> NDArray[np.bool_]:
    """Whether the ends share exactly the vertices opposite to the edge, so that topology is kept."""
    rows, columns = np.concatenate([edges.ends, edges.ends[:, ::-1]]).T
    graph = csr_array((np.ones(len(rows)), (rows, columns)), shape=(count, count))
    u, v = edges.ends[chosen].T
    shared = graph[u].multiply(graph[v]).sum(axis=1)
    return shared == (edges.opposite[chosen] >= 0).sum(axis=1)


def _flip(vertices: Array, faces: Ints) -> Ints:
    edges = Edges(faces)
    rim = edges.boundary_vertices(len(vertices))
    excess = np.bincount(edges.ends.ravel(), minlength=len(vertices)) - np.where(rim, 4, 6)
    inner = np.flatnonzero(~edges.boundary)
    (u, v), (c, d) = edges.ends[inner].T, edges.opposite[inner].T
    before = sum(excess[w] ** 2 for w in (u, v, c, d))
    after = (excess[u] - 1) ** 2 + (excess[v] - 1) ** 2 + (excess[c] + 1) ** 2 + (excess[d] + 1) ** 2
    gain = before - after
    exists = _are_joined(edges, c, d, len(vertices)) | (c == d)
    old = scaled_face_normals(vertices, faces)[edges.faces[inner]].sum(axis=1)
    # faces[:, 0] of an edge holds it as (u, v): new faces (c, u, d) and (c, d, v)
    first, second = np.stack([c, u, d], axis=1), np.stack([c, d, v], axis=1)
    bad = exists | _flat(old, vertices, first) | _flat(old, vertices, second)
    chosen = np.flatnonzero((gain > 0) & ~bad)
    rank = _ranks(-gain[chosen])
    corners = np.stack([u, v, c, d], axis=1)[chosen]
    lowest = _first_over(corners, rank, len(vertices))
    chosen = chosen[(lowest[corners] == rank[:, None]).all(axis=1)]
    faces = faces.copy()
    faces[edges.faces[inner[chosen], 0]] = first[chosen]
    faces[edges.faces[inner[chosen], 1]] = second[chosen]
    return faces


def _flat(old: Array, vertices: Array, faces: Ints) -> NDArray[np.bool_]:
    """Which new faces turn away from the old normal or are slivers."""
    new = scaled_face_normals(vertices, faces)
    sides = vertices[faces] - np.roll(vertices[faces], 1, axis=1)
    longest = np.sum(sides**2, axis=2).max(axis=1)
    return _turned(old, new) | (np.linalg.norm(new, axis=1) < 0.2 * longest)


def _are_joined(edges: Edges, a: Ints, b: Ints, count: int) -> NDArray[np.bool_]:
    keys = edges.ends[:, 0] * count + edges.ends[:, 1]  # ascending, as the edges are sorted
    wanted = np.minimum(a, b) * count + np.maximum(a, b)
    return keys[np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)] == wanted


def _smooth(vertices: Array, faces: Ints, sizing: Sizing, project: Projection) -> Array:
    """Move vertices within the surface towards the centroid of their faces, weighted by area / size^2."""
    edges = Edges(faces)
    count = len(vertices)
    rim = edges.boundary_vertices(count)
    centres = vertices[faces].mean(axis=1)
    weight = np.linalg.norm(scaled_face_normals(vertices, faces), axis=1) / sizing(centres) ** 2
    total, centroid = np.zeros(count), np.zeros((count, 3))
    for k in range(3):
        np.add.at(total, faces[:, k], weight)
        np.add.at(centroid, faces[:, k], weight[:, None] * centres)
    centroid /= total[:, None]
    normal = vertex_normals(vertices, faces, "area")
    ends = edges.ends[edges.boundary]
    centroid[rim] = 0  # on the rim: the mean of the two neighbours there
    for a, b in (ends.T, ends[:, ::-1].T):
        np.add.at(centroid, a, vertices[b] / 2)
    normal[rim, 0] = 0
    move = centroid - vertices
    along = np.einsum("nd,nd->n", move, normal) / np.maximum(np.einsum("nd,nd->n", normal, normal), 1e-12)
    return project(vertices + 0.7 * (move - along[:, None] * normal), rim)

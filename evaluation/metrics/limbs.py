"""Limbs of a body, found on the mesh of its rest pose, and how many of them a map takes to the right limb.

A limb is what sticks out: where the *remoteness* of the surface (the mean geodesic distance of a vertex from
all of the body) has a peak that stands out. Going down from the peaks, the vertices above a level form
islands. An island that meets another one or the trunk is a limb if its peak rises above the place where they
meet by `STANDS_OUT` of the range of the remoteness, and by `SHORTEST`; otherwise (fingers, ears, hooves) it
is a part of what it meets. Arms, legs, head and tail come out so, each from its tip to where it leaves the
body, with no name for any. Nothing is random.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from datasets_gen.compiled import compiled
from datasets_gen.points.farthest import farthest_in_metric
from datasets_gen.shape import Shape
from evaluation.metrics.correspondence import SurfacePoints
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.metrics.unfolding import Floats, Ints

STANDS_OUT = 0.15
"""Height of a limb's peak over its foot, relative to the range of the remoteness."""
SHORTEST = 0.05
"""Height of the lowest peak that can be a limb's, in sqrt(area): a ball has none."""
SAMPLES = 100
"""Vertices that stand for all of the body."""
LEAST = 10
"""A limb of which fewer points were scanned and evaluated says nothing about a map."""


@dataclass(frozen=True)
class Limbs:
    """The limbs of a body.

    Attributes
    ----------
    tips : (L,) int64
        Vertex at the end of each limb, the most remote limb first.
    of_vertex : (v,) int64
        Limb of every vertex; -1 for the trunk.
    remoteness : (v,) float64
        Mean geodesic distance of every vertex from the body, of `remoteness`.
    mirror : (L,) int64 or None
        The limb that is each limb's mirror image, itself for a limb in the middle; -1 where there is none.
        None if the body's mirror map is unknown.
    """

    tips: NDArray[np.int64]
    of_vertex: NDArray[np.int64]
    remoteness: NDArray[np.float64]
    mirror: NDArray[np.int64] | None = None

    def __len__(self) -> int:
        """Return the number of limbs."""
        return len(self.tips)

    def of_points(self, shape: Shape, points: SurfacePoints) -> NDArray[np.int64]:
        """Limb of surface points, that of the nearest corner of their face, (n,); -1 for the trunk."""
        corner = points.barycentrics.argmax(axis=1)
        return self.of_vertex[shape.faces[points.face_ids, corner]]

    def remoteness_of(self, shape: Shape, points: SurfacePoints) -> NDArray[np.float64]:
        """Mean geodesic distance of surface points from the body, (n,): what a random match is off by."""
        corners = self.remoteness[shape.faces[points.face_ids]]
        return np.einsum("nc,nc->n", points.barycentrics, corners)


def find_limbs(shape: Shape, distance: SurfaceDistance, mirror: NDArray[np.int64] | None = None) -> Limbs:
    """The limbs of a body in its rest pose.

    Parameters
    ----------
    shape
        The rest pose.
    distance
        Distances on it.
    mirror : (v,) or None
        Vertex that mirrors each vertex.

    Returns
    -------
    Limbs
        None at all if nothing stands out, as on a ball.
    """
    field = remoteness(shape, distance)
    graph = _edges(shape)
    order = np.argsort(-field, kind="stable")
    least = max(STANDS_OUT * float(np.ptp(field[shape.on_surface])), SHORTEST * float(np.sqrt(shape.area)))
    tips, feet = _islands(order, graph.indptr, graph.indices, field, least)
    rank = np.argsort(-field[tips], kind="stable")
    of_vertex = np.full(len(field), -1, dtype=np.int64)
    for limb, k in enumerate(rank):
        above = np.flatnonzero(field > feet[k])
        part = connected_components(graph[above][:, above], directed=False)[1]
        of_vertex[above[part == part[np.searchsorted(above, tips[k])]]] = limb
    tips = tips[rank]
    return Limbs(tips, of_vertex, field, None if mirror is None else of_vertex[mirror[tips]])


def remoteness(shape: Shape, distance: SurfaceDistance) -> NDArray[np.float64]:
    """Mean geodesic distance of every vertex from the surface, (v,); 0 off the surface.

    The mean is taken over `SAMPLES` vertices far from each other, each weighted by the area of the surface
    that is nearest to it; those of other pieces of the body do not count.
    """
    there = shape.on_surface
    rows = farthest_in_metric(
        lambda k: np.where(there, distance.from_vertices(np.array([k]))[0], 0.0), SAMPLES, int(there.argmax())
    )[1]
    share = np.bincount(shape.faces.ravel(), np.repeat(shape.face_areas / 3, 3), len(there))
    weights = np.bincount(rows.argmin(axis=0), share, len(rows))[:, None] * np.isfinite(rows)
    total = np.maximum(weights.sum(axis=0), 1e-300)
    return np.where(there, (weights * np.where(np.isfinite(rows), rows, 0.0)).sum(axis=0) / total, 0.0)


def limb_shares(
    here: NDArray[np.int64],
    there: NDArray[np.int64],
    shown: NDArray[np.int64],
    mirror: NDArray[np.int64] | None,
) -> tuple[float | None, float | None]:
    """Shares of limbs of which most points are mapped to the right limb, and to its mirror image.

    Of the n_l >= `LEAST` points on limb l, m_l(k) are mapped to limb k. The first share is that of limbs with
    ``m_l(l) > n_l / 2``; the second is that of limbs with a mirror image k other than themselves that have
    ``m_l(k) > n_l / 2``. Only limbs count that the target shows, with their mirror image for the second.

    Parameters
    ----------
    here : (n,)
        Limb of each evaluated source point, -1 for the trunk.
    there : (n,)
        Limb of the place that it is mapped to; -1 for the trunk, or without a match.
    shown : (m,)
        Limb of each point of the target.
    mirror : (L,) or None
        Of `Limbs`.

    Returns
    -------
    right, mirrored : float or None
        In [0, 1]; None if no limb counts, ``mirrored`` also if the mirror map is unknown.
    """
    seen = np.unique(shown)
    limbs = [limb for limb in np.unique(here[here >= 0]) if (here == limb).sum() >= LEAST and limb in seen]
    right = [(there[here == limb] == limb).mean() > 0.5 for limb in limbs]
    mirrored = []
    for limb in limbs if mirror is not None else ():
        image = mirror[limb]  # type: ignore[index]
        if image >= 0 and image != limb and image in seen:
            mirrored.append((there[here == limb] == image).mean() > 0.5)
    return tuple(float(np.mean(each)) if each else None for each in (right, mirrored))  # type: ignore[return-value]


def _edges(shape: Shape) -> csr_array:
    """Which vertices share an edge, (v, v)."""
    tails, heads = shape.faces.ravel(), shape.faces[:, [1, 2, 0]].ravel()
    ends = np.concatenate([tails, heads]), np.concatenate([heads, tails])
    return csr_array((np.ones(len(ends[0]), dtype=np.int8), ends), shape=(len(shape.vertices),) * 2)


@compiled()
def _find(parent: Ints, v: int) -> int:
    """Root of a vertex; paths are halved on the way."""
    while parent[v] != v:
        parent[v] = parent[parent[v]]
        v = parent[v]
    return v


@compiled()
def _islands(order: Ints, indptr: Ints, indices: Ints, field: Floats, least: float) -> tuple[Ints, Floats]:
    """Peaks of a field that rise by `least` above where their islands meet others, and those levels.

    Parameters
    ----------
    order : (v,)
        Vertices by falling field.
    indptr, indices
        Neighbours of each vertex.
    field : (v,)
    least

    Returns
    -------
    tips : (L,) int64
    feet : (L,) float64
    """
    n = len(order)
    parent, peak, trunk = np.full(n, -1), np.arange(n), np.zeros(n, np.bool_)
    tips, feet, found = np.empty(n, np.int64), np.empty(n), 0
    for v in order:
        parent[v] = v
        for k in range(indptr[v], indptr[v + 1]):
            if parent[indices[k]] < 0:
                continue
            a, b = _find(parent, v), _find(parent, indices[k])
            if a == b:
                continue
            if field[peak[b]] > field[peak[a]]:
                a, b = b, a
            if trunk[b] or field[peak[b]] - field[v] >= least:  # both stand out, or are the trunk
                for root in (a, b):
                    if not trunk[root]:
                        tips[found], feet[found], found = peak[root], field[v], found + 1
                trunk[a] = True
            parent[b] = a
    return tips[:found], feet[:found]

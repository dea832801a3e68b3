r"""Rotationally symmetric directions and centres of a cloud [TZCO09, Sec. 3 and 4], all points at once.

`medial.skeletons.equations` says what is computed; here the points of a plane are collected and summed by
compiled code, and all planes are solved together.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from datasets_gen.compiled import compiled, ranges, run_tasks
from medial.skeletons.surface_graph import SurfaceGraph

Float = NDArray[np.float64]

PLANES_PER_TASK = 512
FLAT = 0.01
"""Least eigenvalue of the centre's equations, per point, below which normals are parallel and give no centre:
an arc of a circle has it where it is shorter than 20 degrees."""
SLENDER = 8.0
"""Ratio of the axes of a cross-section from which it is one of a sheet, not of a tube."""
DEEPEST = 2.5
"""A centre this many times as far from the point as the plane's points spread is none: nearly parallel
normals meet anywhere."""
LEAST_VARIANCE = 1e-3
"""Of normals along a direction, below which directions are equally sure."""
FEWEST_IN_PLANE = 4


@dataclass(frozen=True)
class PlaneSums:
    """Sums over the points p_j of each point's plane, relative to that point, with normals n_j.

    Attributes
    ----------
    count : (n,) float64
    normal : (n, 3)
        Sum of n_j.
    normals : (n, 3, 3)
        Sum of n_j n_j^T.
    place : (n, 3)
        Sum of p_j.
    places : (n, 3, 3)
        Sum of p_j p_j^T.
    pull : (n, 3)
        Sum of (I - n_j n_j^T) p_j.
    """

    count: Float
    normal: Float
    normals: Float
    place: Float
    places: Float
    pull: Float


@dataclass(frozen=True)
class SymmetryAxes:
    """The rotational symmetry axis at every point.

    Attributes
    ----------
    directions : (n, 3) float64
        Unit; signs mean nothing.
    centers : (n, 3) float64
        The point itself where there is none.
    radii : (n,) float64
        Distance of the plane's points from the centre within the plane, root mean square.
    tubular : (n,) bool
        Whether the plane cuts something like a tube; elsewhere there is no centre.
    """

    directions: Float
    centers: Float
    radii: Float
    tubular: NDArray[np.bool_]


def first_directions(graph: SurfaceGraph) -> Float:
    """Tangents along which the normals of a point's neighbours change least, (n, 3).

    Without the tangent plane's constraint, it would be the normal itself on all that is round: a plane that
    only touches the body.
    """
    near = graph.matrix() + diags_array(np.ones(len(graph))).tocsr()
    count = near.sum(axis=1)
    mean = near @ graph.normals / count[:, None]
    products = np.einsum("ni,nj->nij", graph.normals, graph.normals).reshape(-1, 9)
    second = (near @ products / count[:, None]).reshape(-1, 3, 3)
    outward = np.einsum("ni,nj->nij", graph.normals, graph.normals)
    tangent = np.eye(3) - outward
    spread = tangent @ (second - np.einsum("ni,nj->nij", mean, mean)) @ tangent
    return np.asarray(np.linalg.eigh(spread + 10 * outward)[1][:, :, 0])


def symmetry_directions(graph: SurfaceGraph, thickness: float, rounds: int) -> Float:
    """Normals of the best cutting planes, (n, 3): iterated, and smoothed after every step.

    Parameters
    ----------
    graph
    thickness
        Largest distance of a plane's points from it.
    rounds
        Number of steps.
    """
    directions, near = first_directions(graph), graph.matrix()
    for _ in range(rounds):
        directions, variance = improved(graph, near, directions, thickness)
        directions = smoothed(near, directions, variance)
    return directions


def improved(
    graph: SurfaceGraph, near: csr_array, directions: Float, thickness: float
) -> tuple[Float, Float]:
    """The directions of least variance of the normals in each plane, and those variances.

    A plane with too few points keeps its direction, with the variance 1.
    """
    sums = plane_sums(graph, near, directions, thickness)
    mean = sums.normal / sums.count[:, None]
    second = sums.normals / sums.count[:, None, None]
    values, vectors = np.linalg.eigh(second - np.einsum("ni,nj->nij", mean, mean))
    enough = sums.count >= FEWEST_IN_PLANE
    found = np.where(enough[:, None], vectors[:, :, 0], directions)
    return found, np.where(enough, np.maximum(values[:, 0], 0), 1.0)


def smoothed(near: csr_array, directions: Float, variance: Float) -> Float:
    """Directions averaged over neighbours, whatever their signs, the surer ones with more weight."""
    weight = 1 / (variance + LEAST_VARIANCE)
    products = weight[:, None] * np.einsum("ni,nj->nij", directions, directions).reshape(-1, 9)
    total = (near @ products + products).reshape(-1, 3, 3)
    return np.asarray(np.linalg.eigh(total)[1][:, :, 2])


def symmetry_axes(graph: SurfaceGraph, directions: Float, thickness: float) -> SymmetryAxes:
    """Centres that are nearest, in least squares, to the lines through the plane's points along the normals.

    Parameters
    ----------
    graph
    directions : (n, 3)
    thickness
        Largest distance of a plane's points from it.
    """
    sums = plane_sums(graph, graph.matrix(), directions, thickness)
    equations = sums.count[:, None, None] * np.eye(3) - sums.normals
    values, vectors = np.linalg.eigh(equations)
    inverse = 1 / np.maximum(values, FLAT * sums.count[:, None])
    offset = np.einsum("nik,nk,njk,nj->ni", vectors, inverse, vectors, sums.pull)
    axes = _cross_sections(sums, directions, offset)
    radius = np.sqrt(axes.sum(axis=1))
    tubular = (
        (sums.count >= FEWEST_IN_PLANE)
        & (values[:, 0] > FLAT * sums.count)
        & (axes[:, 1] <= SLENDER**2 * axes[:, 0])
        & (np.linalg.norm(offset, axis=1) <= DEEPEST * radius)
        & (np.einsum("nd,nd->n", offset, graph.normals) < 0)
    )
    offset[~tubular] = 0
    return SymmetryAxes(directions, graph.points + offset, radius, tubular)


def _cross_sections(sums: PlaneSums, directions: Float, offset: Float) -> Float:
    """Second moments about the centre along both axes of each plane's points, (n, 2), the smaller first."""
    count = sums.count[:, None, None]
    mixed = np.einsum("ni,nj->nij", sums.place, offset)
    about = (sums.places - mixed - mixed.transpose(0, 2, 1)) / count + np.einsum("ni,nj->nij", offset, offset)
    flat = np.eye(3) - np.einsum("ni,nj->nij", directions, directions)
    return np.asarray(np.maximum(np.linalg.eigvalsh(flat @ about @ flat)[:, 1:], 0))


def plane_sums(graph: SurfaceGraph, near: csr_array, directions: Float, thickness: float) -> PlaneSums:
    """Sums over the points of each point's plane: those within reach of it that are joined to the point.

    Parameters
    ----------
    graph
    near : (n, n)
        `SurfaceGraph.matrix`.
    directions : (n, 3)
        Normals of the planes.
    thickness
    """
    arrays = (graph.points, graph.normals, near.indptr.astype(np.int64), near.indices.astype(np.int64))
    spans = ranges(len(graph), PLANES_PER_TASK)
    parts = run_tasks(_sums, [(*arrays, directions, thickness, *span) for span in spans])
    table = np.concatenate(parts)
    square = (slice(None), [[0, 1, 2], [1, 3, 4], [2, 4, 5]])
    return PlaneSums(
        count=table[:, 0],
        normal=table[:, 1:4],
        normals=table[:, 4:10][square],
        place=table[:, 10:13],
        places=table[:, 13:19][square],
        pull=table[:, 19:22],
    )


@compiled()
def _sums(points, normals, indptr, indices, directions, thickness, start, stop):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    table = np.zeros((stop - start, 22))
    seen = np.full(len(points), -1)
    queue = np.empty(len(points), np.int64)
    for i in range(start, stop):
        row = table[i - start]
        x, y, z = points[i]
        a, b, c = directions[i]
        queue[0], seen[i], waiting, done = i, i, 1, 0
        while done < waiting:
            j = queue[done]
            done += 1
            for k in range(indptr[j], indptr[j + 1]):
                m = indices[k]
                if seen[m] != i:
                    seen[m] = i
                    away = a * (points[m, 0] - x) + b * (points[m, 1] - y) + c * (points[m, 2] - z)
                    if abs(away) <= thickness:
                        queue[waiting] = m
                        waiting += 1
        for at in range(waiting):
            j = queue[at]
            p = (points[j, 0] - x, points[j, 1] - y, points[j, 2] - z)
            n = (normals[j, 0], normals[j, 1], normals[j, 2])
            along = n[0] * p[0] + n[1] * p[1] + n[2] * p[2]
            row[0] += 1
            column = 0
            for d in range(3):
                row[1 + d] += n[d]
                row[10 + d] += p[d]
                row[19 + d] += p[d] - along * n[d]
                for e in range(d, 3):
                    row[4 + column] += n[d] * n[e]
                    row[13 + column] += p[d] * p[e]
                    column += 1
    return table

"""Geodesic distances between random vertices of a body: ours against libraries.

    python -m tests.benchmarks.surface_distances [BODY] [PAIRS]

Edge flips (potpourri3d) give exact geodesics, though not always the shortest: errors are relative to the
smaller of their length and that of our path, both of which lie on the surface. Needs potpourri3d.
"""

import sys
import time

import numpy as np
import potpourri3d as pp3d
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from datasets_gen import load
from evaluation.metrics.geodesic import SurfaceDistance


def edge_graph(vertices, faces):
    rows, cols = faces[:, [0, 1, 2]].ravel(), faces[:, [1, 2, 0]].ravel()
    lengths = np.linalg.norm(vertices[rows] - vertices[cols], axis=1)
    return csr_array((lengths, (rows, cols)), shape=(len(vertices), len(vertices)))


def at_vertices(faces, vertices):
    """Face ids and barycentrics of vertices."""
    face = np.empty(faces.max() + 1, np.int64)
    face[faces] = np.arange(len(faces))[:, None]
    face = face[vertices]
    return face, (faces[face] == vertices[:, None]).astype(float)


def length_of(path):
    return np.linalg.norm(np.diff(path, axis=0), axis=1).sum()


def solvers(shape):
    """Functions from two lists of vertices to distances, by name; building them is timed apart."""
    v, f = shape.vertices, shape.faces

    def ours():
        distance = SurfaceDistance(shape)
        return lambda a, b: distance(*at_vertices(f, a), *at_vertices(f, b))

    def flips():
        solver = pp3d.EdgeFlipGeodesicSolver(v, f)
        return lambda a, b: np.array(
            [length_of(solver.find_geodesic_path(i, j)) for i, j in zip(a, b, strict=True)]
        )

    def heat():
        solver = pp3d.MeshHeatMethodDistanceSolver(v, f)
        return lambda a, b: np.array([solver.compute_distance(i)[j] for i, j in zip(a, b, strict=True)])

    def edges():
        graph = edge_graph(v, f)
        return lambda a, b: np.array(
            [dijkstra(graph, directed=False, indices=i)[j] for i, j in zip(a, b, strict=True)]
        )

    return {"ours": ours, "edge flips": flips, "heat method": heat, "Dijkstra on edges": edges}


def main(body="human", pairs="500"):
    shape = load(body).reference
    SurfaceDistance(shape)(*at_vertices(shape.faces, np.array([0])), *at_vertices(shape.faces, np.array([9])))
    a, b = np.random.default_rng(0).integers(len(shape.vertices), size=(2, int(pairs)))
    found, took = {}, {}
    for name, make in solvers(shape).items():
        start = time.perf_counter()
        solver = make()
        built = time.perf_counter()
        found[name] = solver(a, b)
        took[name] = built - start, time.perf_counter() - built
    there = a != b
    best = np.minimum(found["ours"], found["edge flips"])[there]
    sys.stdout.write(f"{body}, {len(shape.vertices)} vertices, {pairs} pairs\n")
    for name, distances in found.items():
        error = 100 * (distances[there] / best - 1)
        build, ask = took[name]
        sys.stdout.write(
            f"{name:18} built in {build:6.2f} s, {1000 * ask / int(pairs):7.3f} ms a pair, "
            f"longer by {error.mean():6.2f} % on average, {error.max():6.1f} % at most, "
            f"{error.min():6.2f} % at least\n"
        )


if __name__ == "__main__":
    main(*sys.argv[1:])

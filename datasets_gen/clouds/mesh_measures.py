"""Measures of a mesh as it is, sound or not, as ``medialbench inspect`` prints them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from datasets_gen.checks import (
    directed_edges,
    edge_face_counts,
    face_components,
    looks_inward,
    repeated_corners,
    winding_conflicts,
)
from datasets_gen.clouds.point_cloud import Array
from datasets_gen.meshes.geometry import face_areas, solid_faces

Faces = NDArray[np.integer]


@dataclass(frozen=True)
class MeshMeasures:
    """What a mesh is like; counts, but for the last two.

    Attributes
    ----------
    vertices, faces : int
    degenerate : int
        Faces without area.
    repeated : int
        Faces with the same corners as an earlier one.
    unreferenced : int
        Vertices of no face.
    pieces : int
        Of faces with area that share a vertex.
    boundary_edges, boundary_loops : int
        Edges of one face, and how many rims they make.
    crowded_edges : int
        Of more than two faces.
    winding_conflicts : int
        Edges whose faces are wound against each other.
    inward : bool
        Whether a closed, or nearly closed, mesh looks inward.
    caps : float or None
        Area of flat caps over the boundaries, over that of mesh and caps; None where the winding does not
        tell.
    """

    vertices: int
    faces: int
    degenerate: int
    repeated: int
    unreferenced: int
    pieces: int
    boundary_edges: int
    boundary_loops: int
    crowded_edges: int
    winding_conflicts: int
    inward: bool
    caps: float | None


def measure_mesh(vertices: Array, faces: Faces) -> MeshMeasures:
    """Measure a mesh with ids of faces in range and finite vertices; it may have no face with area."""
    solid = faces[solid_faces(vertices, faces) & ~repeated_corners(faces)]
    distinct = np.unique(np.sort(faces, axis=1), axis=0)
    rims, loops, caps = _rims(vertices, solid)
    counts = edge_face_counts(solid) if len(solid) else np.zeros(0, np.int64)
    crowded, conflicts = int((counts > 2).sum()), winding_conflicts(solid) if len(solid) else 0
    area = float(face_areas(vertices, solid).sum())
    told = not crowded and not conflicts and area > 0
    return MeshMeasures(
        len(vertices),
        len(faces),
        len(faces) - len(solid),
        len(faces) - len(distinct),
        len(vertices) - len(np.unique(faces)),
        len(np.unique(face_components(solid))) if len(solid) else 0,
        len(rims),
        loops,
        crowded,
        conflicts,
        bool(len(solid)) and looks_inward(vertices, solid),
        caps / (area + caps) if told else None,
    )


def _rims(vertices: Array, faces: Faces) -> tuple[NDArray[np.int64], int, float]:
    """Edges of one face, how many rims they make, and the area of flat caps over these."""
    edges = directed_edges(faces)
    if not len(edges):
        return edges, 0, 0.0
    _, index, counts = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    rims = edges[counts[index.ravel()] == 1]
    if not len(rims):
        return rims, 0, 0.0
    ids, compact = np.unique(rims, return_inverse=True)
    ends = compact.reshape(-1, 2)
    graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(len(ids), len(ids)))
    loops, label = connected_components(graph, directed=False)
    of_edge = label[ends[:, 0]]
    size = np.bincount(label, minlength=loops)
    centre = np.zeros((loops, 3))
    np.add.at(centre, label, vertices[ids])
    centre /= size[:, None]
    area = np.zeros((loops, 3))
    a, b = (vertices[rims[:, k]] - centre[of_edge] for k in range(2))
    np.add.at(area, of_edge, np.cross(a, b) / 2)  # the cap of a rim that is not flat has this at least
    return rims, int(loops), float(np.linalg.norm(area, axis=1).sum())

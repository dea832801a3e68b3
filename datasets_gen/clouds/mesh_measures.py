"""Measures of a mesh as it is, sound or not, as ``medialbench inspect`` prints them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.checks import (
    edge_face_counts,
    face_components,
    looks_inward,
    repeated_corners,
    winding_conflicts,
)
from datasets_gen.clouds.point_cloud import Array
from datasets_gen.meshes.boundaries import boundary_rims
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
    rims, rim_of = boundary_rims(solid)
    caps = _cap_area(vertices, rims, rim_of)
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
        len(np.unique(rim_of)),
        crowded,
        conflicts,
        bool(len(solid)) and looks_inward(vertices, solid),
        caps / (area + caps) if told else None,
    )


def _cap_area(vertices: Array, rims: NDArray[np.int64], rim_of: NDArray[np.int64]) -> float:
    """Area of flat caps over rims; the cap of a rim that is not flat has this at least."""
    if not len(rims):
        return 0.0
    ids, first = np.unique(rims, return_index=True)
    label = rim_of[first // 2]  # of each vertex
    size = np.bincount(label)
    centre, area = np.zeros((len(size), 3)), np.zeros((len(size), 3))
    np.add.at(centre, label, vertices[ids])
    centre /= size[:, None]
    a, b = (vertices[rims[:, k]] - centre[rim_of] for k in range(2))
    np.add.at(area, rim_of, np.cross(a, b) / 2)
    return float(np.linalg.norm(area, axis=1).sum())

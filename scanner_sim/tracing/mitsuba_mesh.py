"""Mitsuba's copy of a shape: same faces, vertices split where they have several normals."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.meshes.geometry import solid_faces
from datasets_gen.shape import Shape
from scanner_sim.tracing.materials import Attributes


def build_mesh(
    mi: Any,
    shape: Shape,
    vertices: NDArray[np.float64],
    normals: NDArray[np.float64] | None,
    surface: Any,
    attributes: Attributes | None = None,
) -> Any:
    """Mitsuba's copy of a mesh.

    Faces keep their numbers; those without area are shrunk to a point, which no ray hits. A vertex whose
    corners have several normals is split, so vertices may become more.

    Parameters
    ----------
    mi
        Mitsuba with its variant set.
    shape
        Gives the faces.
    vertices : (v, 3)
        Positions in the rig, mm.
    normals : (f, 3, 3)
        Of the corners, for smooth shading; None: flat.
    surface
        A Mitsuba BSDF; None: the mesh emits face numbers, counted from 1, as light.
    attributes
        For textures of the surface.
    """
    extra = dict(attributes or {})
    uv = extra.pop("vertex_uv", None)
    properties = mi.Properties()
    if surface is None:
        number = {"type": "mesh_attribute", "name": "face_number"}
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": number})
        extra = {"face_number": np.arange(1.0, len(shape.faces) + 1)}
    else:
        properties["bsdf"] = surface
    faces = np.where(solid_faces(shape.vertices, shape.faces)[:, None], shape.faces, shape.faces[:, :1])
    source, faces = (np.arange(len(vertices)), faces) if normals is None else split_vertices(faces, normals)
    properties["face_normals"] = normals is None
    options = {"has_vertex_normals": normals is not None, "has_vertex_texcoords": uv is not None}
    mesh = mi.Mesh("object", len(source), len(faces), props=properties, **options)
    for name, values in extra.items():
        array = np.asarray(values, np.float32)
        array = array[source] if name.startswith("vertex_") else array
        mesh.add_attribute(name, array.size // len(array), array.ravel())
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = vertices[source].astype(np.float32).ravel()
    parameters["faces"] = faces.astype(np.uint32).ravel()
    if normals is not None:
        of_vertex = np.zeros((len(source), 3), np.float32)
        of_vertex[faces] = normals
        parameters["vertex_normals"] = of_vertex.ravel()
    if uv is not None:
        parameters["vertex_texcoords"] = np.asarray(uv, np.float32)[source].ravel()
    parameters.update()
    return mesh


def split_vertices(
    faces: NDArray[np.integer], normals: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Vertices with one normal each, made of vertices whose corners have several.

    Parameters
    ----------
    faces : (f, 3)
    normals : (f, 3, 3)
        Of the corners.

    Returns
    -------
    source : (w,) int64
        The vertex that each of the new ones repeats; the first are the old ones in their order.
    faces : (f, 3) int64
        The same corners on new vertices.
    """
    corners, given = faces.ravel().astype(np.int64), normals.reshape(-1, 3)
    count = int(corners.max()) + 1
    own = np.zeros((count, 3))
    own[corners[::-1]] = given[::-1]  # of the first corner of each vertex
    other = np.flatnonzero((own[corners] != given).any(axis=1))
    rows = np.column_stack([corners[other], given[other]])
    distinct, place = np.unique(rows, axis=0, return_inverse=True)
    corners[other] = count + place.ravel()
    return np.concatenate([np.arange(count), distinct[:, 0].astype(np.int64)]), corners.reshape(-1, 3)

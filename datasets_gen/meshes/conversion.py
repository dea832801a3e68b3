"""Meshes of any kind that users hold, as a checked `Shape`."""

import os
from typing import Any

import numpy as np

from datasets_gen.checks import admitted, scannable
from datasets_gen.meshes.files import load_mesh
from datasets_gen.records import InputError
from datasets_gen.shape import Shape
from datasets_gen.values import real_array

ACCEPTED = "a Shape, the path of a mesh file, a trimesh.Trimesh, or (vertices, faces)"


def as_shape(
    mesh: Any, *, name: str = "mesh", repair: bool = False, units: str = "unknown", strict: bool = True
) -> Shape:
    """Turn what a user holds into a checked shape with its faces wound outward.

    Parameters
    ----------
    mesh
        A `Shape`; the path of a file that `load_mesh` reads; a ``trimesh.Trimesh``; or a pair of vertices
        (v, 3) and faces (f, 3). A trimesh keeps its order of vertices and faces.
    name
        Name of a shape that is made from a trimesh or from arrays.
    repair
        Go on with the largest component and without degenerate or repeated faces.
    units
        Length unit to note in a shape that is made here.
    strict
        Refuse meshes without ground truth; if not, only those that cannot be scanned
        (`datasets_gen.checks.scannable`).

    Returns
    -------
    Shape
        The very same object if a sound `Shape` is given.

    Raises
    ------
    InputError
        If it is none of these, or the mesh cannot be used (`datasets_gen.check_mesh`).
    """
    if isinstance(mesh, str | os.PathLike):
        return load_mesh(mesh, repair=repair, units=units, strict=strict)
    given = mesh if isinstance(mesh, Shape) else _from_arrays(*_arrays(mesh), name, units)
    checked = admitted([given], repair)[0] if strict else scannable(given, repair)
    unchanged = checked.vertices is given.vertices and checked.faces is given.faces
    return given if unchanged else checked


def _arrays(mesh: Any) -> tuple[Any, Any]:
    """Vertices and faces of a trimesh or of a pair."""
    if isinstance(mesh, tuple | list) and len(mesh) == 2:
        return mesh[0], mesh[1]
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return mesh.vertices, mesh.faces
    if hasattr(mesh, "geometry"):  # trimesh reads some files as scenes
        raise InputError("a scene may hold several meshes; give one of them: scene.to_mesh()")
    raise InputError(f"{type(mesh).__name__!r} is no mesh; give {ACCEPTED}")


def _from_arrays(vertices: Any, faces: Any, name: str, units: str) -> Shape:
    """A shape of copies of the arrays; raises InputError where they are no triangle mesh."""
    try:
        points, triangles = real_array(vertices, "the array of vertices").copy(), np.array(faces)
    except (TypeError, ValueError) as error:
        raise InputError(f"{error}; give {ACCEPTED}") from error
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"vertices must have shape (v, 3), got {points.shape}")
    if triangles.size == 0:
        triangles = np.empty((0, 3), dtype=np.int32)
    if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu":
        raise InputError(
            f"faces must be whole numbers of shape (f, 3), got {triangles.dtype} of shape {triangles.shape}; "
            "cut polygons into triangles"
        )
    if len(triangles) and (triangles.min() < 0 or triangles.max() >= len(points)):
        wrong = int(triangles.min() if triangles.min() < 0 else triangles.max())
        raise InputError(f"faces name vertex {wrong}, but there are {len(points)} vertices")
    return Shape(points, triangles.astype(np.int32), name, name, name, units)

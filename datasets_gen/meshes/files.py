"""The one way in which the project reads and writes mesh files."""

import logging
import os
from pathlib import Path

import numpy as np

from datasets_gen.checks import admitted, scannable
from datasets_gen.clouds.file_formats import SURFACE_SUFFIXES, checked_file, read_points
from datasets_gen.clouds.point_cloud import PointCloud
from datasets_gen.records import InputError, atomic_path
from datasets_gen.shape import Shape

MESH_SUFFIXES = (".ply", ".obj", ".off")
"""Endings of meshes of a folder of poses, and of those that are written: formats that keep all vertices."""

_log = logging.getLogger(__name__)


def read_mesh(path: str | os.PathLike[str], subject: str | None = None, units: str = "unknown") -> Shape:
    """Read a mesh file as it is: vertices and faces in the order of the file, nothing merged or dropped.

    Polygons are cut into triangles in file order, so poses with the same polygons keep the same triangles.
    STL and glTF repeat vertices: those at one place are one, and the log says so.

    Parameters
    ----------
    path
        A ``.ply``, ``.obj``, ``.off``, ``.stl``, ``.glb`` or ``.gltf`` file.
    subject
        Default: the name of the file.
    units
        Length unit to note in the shape.

    Raises
    ------
    InputError
        If the file is missing, of another type or not readable.
    """
    file = checked_file(path, SURFACE_SUFFIXES, "mesh")
    found = read_points(file)
    if not found.is_mesh:  # a point cloud or a path
        raise InputError(f"{str(path)!r} has no faces; a point cloud cannot be scanned, give a mesh")
    for remark in found.remarks:
        _log.warning("%s: %s", file.name, remark)
    return as_mesh(found, file, subject, units)


def as_mesh(found: PointCloud, file: Path, subject: str | None = None, units: str = "unknown") -> Shape:
    """The shape that a file with faces holds; its name is that of the file."""
    subject = subject or file.stem
    name = file.stem if subject == file.stem else f"{subject}/{file.stem}"
    faces = np.zeros((0, 3), np.int32) if found.faces is None else found.faces.astype(np.int32)
    return Shape(found.points, faces, name, subject, file.stem, units)


def load_mesh(
    path: str | os.PathLike[str], *, repair: bool = False, units: str = "unknown", strict: bool = True
) -> Shape:
    """Load one mesh, checked, with its faces wound outward.

    Parameters
    ----------
    path
        A file that `read_mesh` reads, or a shape saved as ``.npz``.
    repair
        Go on with the largest component and without degenerate or repeated faces.
    units
        Length unit to note in the shape.
    strict
        Refuse meshes without ground truth; if not, only those that cannot be scanned
        (`datasets_gen.checks.scannable`).

    Raises
    ------
    InputError
        If the file or the mesh in it cannot be used (`datasets_gen.check_mesh`).
    """
    shape = Shape.load(path) if Path(path).suffix == ".npz" else read_mesh(path, units=units)
    return admitted([shape], repair)[0] if strict else scannable(shape, repair)


def write_mesh(shape: Shape, path: str | os.PathLike[str]) -> None:
    """Write a shape as a binary ``.ply`` (single precision) or as ``.obj`` or ``.off``, atomically.

    Raises
    ------
    InputError
        For another suffix, or a folder that cannot be written.
    """
    file = Path(path)
    if file.suffix.lower() not in MESH_SUFFIXES:
        raise InputError(f"cannot write {str(path)!r}; choose one of {', '.join(MESH_SUFFIXES)}")
    import trimesh

    with atomic_path(file) as temporary:
        trimesh.Trimesh(shape.vertices, shape.faces, process=False).export(temporary)

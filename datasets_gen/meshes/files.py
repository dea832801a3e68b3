"""The one way in which the project reads and writes mesh files."""

import os
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from datasets_gen.checks import admitted, scannable
from datasets_gen.meshes.bad_lines import bad_line
from datasets_gen.records import InputError, atomic_path
from datasets_gen.shape import Shape

MESH_SUFFIXES = (".ply", ".obj", ".off")
OBJ_PARTITIONS = (b"mtllib", b"usemtl", b"o ", b"g ", b"s ", b"o\t", b"g\t")


def read_mesh(path: str | os.PathLike[str], subject: str | None = None, units: str = "unknown") -> Shape:
    """Read a mesh file as it is: vertices and faces in the order of the file, nothing merged or dropped.

    Polygons are cut into triangles in file order, so poses with the same polygons keep the same triangles.

    Parameters
    ----------
    path
        A ``.ply``, ``.obj`` or ``.off`` file.
    subject
        Default: the name of the file.
    units
        Length unit to note in the shape.

    Raises
    ------
    InputError
        If the file is missing, of another type or not readable.
    """
    file = Path(path)
    if file.suffix.lower() not in MESH_SUFFIXES:
        kinds = ", ".join(MESH_SUFFIXES)
        raise InputError(f"{str(path)!r} is not a mesh file this project reads; it reads {kinds}")
    if not file.is_file():
        raise InputError(
            f"{str(path)!r} {'is a folder' if file.is_dir() else 'does not exist'}; give a mesh file"
        )
    try:
        mesh = _parsed(file.read_bytes(), file.suffix.lower()[1:])
    except PermissionError as error:
        raise InputError(f"{str(path)!r} cannot be read: {error.strerror}") from error
    except Exception as error:  # parsers raise anything from IndexError to struct.error on a broken file
        reason = why_unreadable(file, error)
        raise InputError(
            f"{str(path)!r} is cut short or no {file.suffix} mesh ({reason}); export it again"
        ) from error
    subject = subject or file.stem
    name = file.stem if subject == file.stem else f"{subject}/{file.stem}"
    vertices, faces = np.array(getattr(mesh, "vertices", np.zeros((0, 3)))), getattr(mesh, "faces", ())
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        why = bad_line(file) or f"vertices of shape {vertices.shape}, not (v, 3)"
        raise InputError(f"{str(path)!r} cannot be used ({why}); export it again")
    check_rows(file, vertices, faces)
    if len(faces) == 0:  # a point cloud or a path
        raise InputError(f"{str(path)!r} has no faces; a point cloud cannot be scanned, give a mesh")
    return Shape(
        vertices.astype(np.float64), np.array(faces, dtype=np.int32), name, subject, file.stem, units
    )


def _parsed(content: bytes, kind: str) -> Any:
    """What trimesh makes of a file, in the order of the file.

    An OBJ loses its materials, objects and groups first: trimesh would make a mesh of each, in another order.
    """
    import trimesh  # in the functions that need it: a start without it takes half as long

    if kind == "ply":  # texture coordinates of faces would split vertices at seams
        plain: Any = {"fix_texture": False, "skip_materials": True}
        return trimesh.load(BytesIO(content), file_type=kind, process=False, **plain)
    if kind != "obj":
        return trimesh.load(BytesIO(content), file_type=kind, process=False)
    lines = b"\n".join(_bare_obj(content))
    return trimesh.load(BytesIO(lines), file_type=kind, process=False, maintain_order=True)


def _bare_obj(content: bytes) -> Iterator[bytes]:
    """Lines of an OBJ without materials, objects and groups; its faces name vertices alone, counted from 1.

    A negative index counts backwards from the last vertex before the face; trimesh knows none.
    """
    count = 0
    for line in content.splitlines():
        if line.startswith((b"v ", b"v\t")):
            count += 1
        if line.startswith(b"f ") and b"-" in line:
            corners = [_corner(corner) for corner in line.split()[1:]]
            yield b"f " + b" ".join(b"%d" % (c if c > 0 else count + 1 + c) for c in corners)
        elif not line.startswith(OBJ_PARTITIONS):
            yield line


def _corner(text: bytes) -> int:
    """Vertex number of a corner such as ``7/1/3``."""
    return int(text.partition(b"/")[0])


def why_unreadable(file: Path, error: Exception) -> str:
    """Why a parser failed: the first bad line of a file in text, else what the parser says."""
    return bad_line(file) or (str(error).splitlines()[0] if str(error) else type(error).__name__)


def check_rows(file: Path, vertices: Any, faces: Any = ()) -> None:
    """Raise InputError, with the line, for a file in text that a parser has read and that is wrong.

    Parsers leave out rows that are missing or too short, and take any number for a vertex.

    Parameters
    ----------
    file
    vertices : (v, 3)
        As read.
    faces : (f, 3), optional
    """
    corners = np.asarray(faces)
    lost = corners.size and (corners.min() < 0 or corners.max() >= len(vertices))
    wrong = bad_line(file, thorough=bool(lost) or not np.isfinite(vertices).all())
    if wrong:
        raise InputError(f"{str(file)!r} cannot be used ({wrong}); export it again")


def load_mesh(
    path: str | os.PathLike[str], *, repair: bool = False, units: str = "unknown", strict: bool = True
) -> Shape:
    """Load one mesh, checked, with its faces wound outward.

    Parameters
    ----------
    path
        A ``.ply``, ``.obj`` or ``.off`` file, or a shape saved as ``.npz``.
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

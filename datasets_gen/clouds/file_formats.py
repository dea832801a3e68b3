"""The one way in which files of points and of meshes get in: by their ending, understood or refused."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from datasets_gen.clouds.array_clouds import read_npy, read_npz
from datasets_gen.clouds.gltf_scenes import read_gltf
from datasets_gen.clouds.las_clouds import read_las
from datasets_gen.clouds.obj_surfaces import read_obj
from datasets_gen.clouds.off_surfaces import read_off
from datasets_gen.clouds.pcd_clouds import read_pcd
from datasets_gen.clouds.ply_surfaces import read_ply
from datasets_gen.clouds.point_cloud import PointCloud
from datasets_gen.clouds.stl_surfaces import read_stl
from datasets_gen.clouds.text_columns import as_cloud_of_columns, columns_given
from datasets_gen.clouds.text_tables import read_table
from datasets_gen.meshes.bad_lines import bad_line
from datasets_gen.records import InputError, no_file

TEXT_SUFFIXES = (".xyz", ".txt", ".pts", ".csv", ".asc")
SURFACE_SUFFIXES = (".ply", ".obj", ".off", ".stl", ".glb", ".gltf")
"""Endings of files that may hold faces, beside ``.npz``."""
FILE_SUFFIXES = (".npz", *SURFACE_SUFFIXES, *TEXT_SUFFIXES, ".pcd", ".npy", ".las", ".laz")
"""Endings of all files that are read."""
WITH_LINES = (".ply", ".obj", ".off")

_BY_CONTENT: dict[str, Callable[[bytes], PointCloud]] = {
    ".ply": read_ply,
    ".obj": read_obj,
    ".off": read_off,
    ".stl": read_stl,
    ".pcd": read_pcd,
}


def read_points(path: str | os.PathLike[str], columns: str | None = None) -> PointCloud:
    """Read what a file holds: points, normals and faces, in the order of the file.

    Parameters
    ----------
    path
        Its ending is one of `FILE_SUFFIXES`; records of this project (``.npz``) have readers of their own.
    columns
        Names of the columns of a text or an array, as ``"x y z nx ny nz"``; default: as the file says, or as
        its content tells.

    Raises
    ------
    InputError
        If the file is missing or cannot be understood: with the line of a text.
    """
    file = checked_file(path, FILE_SUFFIXES)
    names, suffix = columns_given(columns), file.suffix.lower()
    if names and suffix not in (*TEXT_SUFFIXES, ".npy"):
        raise InputError(
            f"columns are named for texts ({', '.join(TEXT_SUFFIXES)}) and .npy, not for {suffix}"
        )
    try:
        found = _read(file, suffix, names)
        if found.faces is not None and np.abs(found.faces).max(initial=0) > np.iinfo(np.int32).max:
            raise ValueError("a face names a vertex beyond 2,147,483,647")
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read: {error.strerror or error}") from error
    except Exception as error:  # parsers raise anything from IndexError to struct.error on a broken file
        reason = why_unreadable(file, error)
        raise InputError(
            f"{str(path)!r} is cut short or no {file.suffix} file ({reason}); export it again"
        ) from error
    check_rows(file, found)
    return found


def _read(file: Path, suffix: str, columns: tuple[str, ...]) -> PointCloud:
    where = repr(str(file))
    if suffix in (".glb", ".gltf"):
        return read_gltf(file)
    if suffix in TEXT_SUFFIXES:
        return as_cloud_of_columns(read_table(file, len(columns)), where, columns)
    content = file.read_bytes()
    if suffix == ".npy":
        return read_npy(content, where, columns)
    if suffix == ".npz":
        return read_npz(content, where)
    if suffix in (".las", ".laz"):
        return read_las(content, where)
    return _BY_CONTENT[suffix](content)


def checked_file(
    path: str | os.PathLike[str], suffixes: tuple[str, ...], kind: str = "cloud or mesh"
) -> Path:
    """The path of a file that is there and has one of some endings.

    Raises
    ------
    InputError
        If it is not; `kind` is for the message.
    """
    file = Path(path)
    if file.suffix.lower() not in suffixes:
        raise InputError(
            f"{str(path)!r} is no {kind} file this project reads; it reads {', '.join(suffixes)}"
        )
    if not file.is_file():
        raise InputError(f"{str(path)!r} {no_file(file) or 'does not exist'}; give a {kind} file")
    return file


def why_unreadable(file: Path, error: Exception) -> str:
    """Why a parser failed: the first bad line of a file in text, else what the parser says."""
    line = bad_line(file) if file.suffix.lower() in WITH_LINES else ""
    return line or " ".join(str(error).split())[:200] or type(error).__name__


def check_rows(file: Path, found: PointCloud) -> None:
    """Raise InputError, with the line, for a file in text that was read although it is wrong.

    Parsers leave out rows that are missing or too short, and take any number for a vertex. Points of a cloud
    that are NaN are no fault: they are dropped later, with a count.
    """
    if file.suffix.lower() not in WITH_LINES:
        return
    corners: Any = np.zeros(0) if found.faces is None else found.faces
    lost = corners.size and (corners.min() < 0 or corners.max() >= len(found.points))
    gaps = found.is_mesh and not np.isfinite(found.points).all()
    wrong = bad_line(file, thorough=bool(lost) or gaps)
    if wrong:
        raise InputError(f"{str(file)!r} cannot be used ({wrong}); export it again")

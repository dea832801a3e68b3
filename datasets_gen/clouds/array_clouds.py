"""Clouds that NumPy has written: ``.npy`` with 3 or 6 columns, ``.npz`` with points and normals."""

from io import BytesIO
from typing import IO, Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from datasets_gen.clouds.column_names import as_names
from datasets_gen.clouds.point_cloud import Array, PointCloud
from datasets_gen.clouds.text_columns import as_cloud_of_columns, cloud_of_named
from datasets_gen.clouds.text_tables import TextTable
from datasets_gen.records import InputError
from datasets_gen.values import real_array

POINTS = ("points", "xyz", "vertices", "pos")
NORMALS = ("normals", "normal", "vertex_normals")
FACES = ("faces", "triangles")
MOST_COLUMNS = 16
"""Of a table of three or six rows; one with more is transposed."""


def read_npy(content: bytes, where: str, columns: tuple[str, ...] = ()) -> PointCloud:
    """Read an array: of (n, 3) or more columns, which are told as those of a text; or with named fields.

    Raises
    ------
    InputError
        If the columns cannot be told.
    ValueError
        If the file is damaged.
    """
    array = _array(BytesIO(content), where)
    if array.dtype.names:
        names = [(as_names([name, "x"]) or [name])[0] for name in array.dtype.names]
        table = np.column_stack([_column(array[name], name) for name in array.dtype.names])
        return cloud_of_named(table, columns or tuple(names), where)
    if array.ndim != 2 or array.shape[1] < 3:
        raise InputError(
            f"{where} holds an array of shape {array.shape}; give (n, 3), or (n, 6) with normals"
        )
    if array.shape[0] in (3, 6) and array.shape[1] > MOST_COLUMNS:
        raise InputError(
            f"{where} holds an array of shape {array.shape}; transpose it to (n, {array.shape[0]})"
        )
    table = real_array(array, where)
    rows = TextTable(table, np.arange(1, len(table) + 1), (), ())
    return as_cloud_of_columns(rows, where, columns)


def _column(values: NDArray[Any], name: str) -> Array:
    """A field with a number per point."""
    if values.ndim != 1:
        raise ValueError(f"field {name!r} has shape {values.shape}")
    return real_array(values, f"field {name!r}")


def read_npz(content: bytes, where: str) -> PointCloud:
    """Read ``points``, ``normals`` and ``faces`` of an archive of plain arrays, those that there are.

    Raises
    ------
    InputError
        If there are no points, or the arrays do not fit together.
    ValueError
        If the file is damaged.
    """
    with ZipFile(BytesIO(content)) as file:
        names = {name.removesuffix(".npy").lower(): name for name in file.namelist()}
        points, normals, faces = (_named(file, names, each) for each in (POINTS, NORMALS, FACES))
    if points is None:
        there = ", ".join(sorted(names))[:200] or "none"
        raise InputError(f"{where} has no array called {' or '.join(POINTS)}; it has {there}")
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"{where} has points of shape {points.shape}; give (n, 3)")
    if normals is not None and normals.shape != points.shape:
        raise InputError(
            f"{where} has normals of shape {normals.shape} and points of shape {points.shape}; "
            "give a normal for each point"
        )
    triangles = None
    if faces is not None and faces.size:
        if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
            raise InputError(f"{where} has faces of shape {faces.shape}; give whole numbers of shape (f, 3)")
        triangles = faces.astype(np.int64)
    return PointCloud(
        real_array(points, where), None if normals is None else real_array(normals, where), (), triangles
    )


def _named(file: ZipFile, names: dict[str, str], wanted: tuple[str, ...]) -> NDArray[Any] | None:
    """The first array of a name, all of it: its checksum is compared at its end."""
    found = next((names[name] for name in wanted if name in names), None)
    if found is None:
        return None
    with file.open(found) as stream:
        return _array(stream, found)


def _array(stream: IO[bytes], name: str) -> NDArray[Any]:
    """All of a stored array, of numbers."""
    array: NDArray[Any] = np.lib.format.read_array(stream, allow_pickle=False)
    if stream.read(1):
        raise ValueError(f"{name} is longer than its header says")
    if array.dtype.kind not in "iufcSUV":
        raise ValueError(f"{name} holds {array.dtype}, no numbers")
    return array

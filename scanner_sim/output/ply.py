"""Points with any number of attributes as binary PLY."""

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import atomic_path

_TYPES = {"<f8": "double", "<f4": "float", "<i4": "int", "|u1": "uchar"}


def write_points(
    path: str | os.PathLike[str], properties: Mapping[str, NDArray[Any]], comments: Sequence[str] = ()
) -> None:
    """Write points as the vertices of a binary little-endian PLY, atomically.

    Parameters
    ----------
    path
        Conventionally ``.ply``.
    properties
        One array (n,) per property, in order: float64 is written as double, float32 as float, int32 as
        int, uint8 as uchar.
    comments
        Lines of the header; characters beyond ASCII are replaced.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    columns = {name: np.asarray(values) for name, values in properties.items()}
    kinds = {name: values.dtype.newbyteorder("<") for name, values in columns.items()}
    count = len(next(iter(columns.values())))
    rows = np.empty(count, dtype=list(kinds.items()))
    for name, values in columns.items():
        rows[name] = values
    header = [
        "ply",
        "format binary_little_endian 1.0",
        *(f"comment {line}" for line in comments),
        f"element vertex {count}",
        *(f"property {_TYPES[kind.str]} {name}" for name, kind in kinds.items()),
        "end_header",
    ]
    with atomic_path(path) as temporary:
        temporary.write_bytes("\n".join(header).encode("ascii", "replace") + b"\n" + rows.tobytes())

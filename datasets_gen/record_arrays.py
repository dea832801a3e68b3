"""Whether what a file holds fits its record: shapes and types of arrays, ranges of ids, other values.

Each function raises ValueError; `datasets_gen.records.unpacking` makes an `InputError` with the file's name.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from datasets_gen.values import check_types

TYPES = {"float": ("<f4", "<f8"), "int": ("<i4", "<i8")}
"""Words of layouts, and the types that compiled code takes."""


def check_layout(arrays: Mapping[str, Any], layout: Mapping[str, str], finite: str = "") -> dict[str, int]:
    """Check types and shapes, and that all numbers of some arrays are finite.

    Parameters
    ----------
    arrays
        By name; those that the layout does not name are not looked at.
    layout
        By name: ``"float n 3"`` is an array (n, 3) of floats, ``"int n"`` one of integers. A letter is the
        same length wherever it stands; all arrays that share a letter have to agree.
    finite
        Names of arrays without NaN and infinity, with spaces between them.

    Returns
    -------
    dict
        Length by letter.

    Raises
    ------
    ValueError
        For the first array that is missing, or does not fit.
    """
    lengths: dict[str, int] = {}
    for name, words in layout.items():
        kind, *dims = words.split()
        if name not in arrays:
            raise ValueError(f"{name} is missing")
        array = np.asarray(arrays[name])
        if array.dtype.str not in TYPES[kind]:
            raise ValueError(f"{name} is of type {array.dtype}, not {kind}")
        expected = [
            int(dim) if dim.isdigit() else lengths.setdefault(dim, size)
            for dim, size in zip(dims, array.shape, strict=False)
        ]
        if array.ndim != len(dims) or list(array.shape) != expected:
            raise ValueError(f"{name} has shape {array.shape}, not ({', '.join(map(str, expected or dims))})")
    for name in finite.split():
        if not np.isfinite(arrays[name]).all():
            raise ValueError(f"{name} has numbers that are NaN or infinite")
    return lengths


def check_ids(ids: NDArray[np.integer], count: int, name: str, least: int = 0) -> None:
    """Check that ids are at least `least` and below a count."""
    if ids.size and (ids.min() < least or ids.max() >= count):
        wrong = ids.min() if ids.min() < least else ids.max()
        raise ValueError(f"{name} holds {wrong}, outside [{least}, {count - 1}]")


def check_values(cls: Callable[..., Any], values: Mapping[str, Any]) -> None:
    """Check values against the annotations of a class (`datasets_gen.values.check_types`)."""
    try:
        check_types(cls, values)
    except InputError as error:
        raise ValueError(str(error)) from error

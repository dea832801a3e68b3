"""Writing of correspondence files, which say direction and first index where the format has room for it."""

from pathlib import Path

import numpy as np

from datasets_gen.correspondences.point_map import FORMATS, PointMap
from datasets_gen.records import InputError, atomic_path

WRITTEN = (".npz", ".txt", ".csv", ".map", ".vts", ".corr", ".mat")
"""Endings of files that can be written."""


def write_map(
    found: PointMap, path: Path, *, names: tuple[str, str] = ("source", "target"), first_id: int = 0
) -> None:
    """Write a correspondence file, atomically.

    Parameters
    ----------
    found
    path
        Its ending, one of `WRITTEN`, is the format.
    names
        Of source and target, for headers.
    first_id
        Index of the first target point in ``.txt`` and ``.csv``: 0 or 1. Other formats have their own.

    Raises
    ------
    InputError
        For another ending or first index, or a map that the format cannot hold.
    """
    suffix = path.suffix.lower()
    if suffix not in WRITTEN:
        raise InputError(f"cannot write {str(path)!r}; a map may end in {', '.join(WRITTEN)}")
    if first_id not in (0, 1):
        raise InputError(f"indices count from 0 or 1, not from {first_id!r}")
    if suffix != ".corr" and found.weights is not None:
        raise InputError(f"{suffix} holds indices of points, the map has triangles; write .corr")
    if suffix == ".corr" and found.weights is None:
        raise InputError(".corr holds triangles with weights; the map has indices of points")
    own = FORMATS[suffix][0]
    first = first_id if own is None else own
    ids = np.where(found.matched, found.ids + first, -1)
    sure = np.where(found.matched, 1.0, 0.0) if found.confidence is None else found.confidence
    said = (
        f"first_id = {first}; row i is the point of {_word(names[1])} for point i of {_word(names[0])}; "
        "-1 is no match"
    )
    with atomic_path(path) as temporary:
        if suffix == ".npz":
            np.savez(temporary, source_to_target=ids, confidence=sure)
        elif suffix == ".mat":
            from scipy.io import savemat

            columns = {"source_to_target": ids[:, None].astype(float), "confidence": sure[:, None]}
            savemat(temporary, {**columns, "first_id": 1.0, "direction": said}, do_compression=True)
        elif suffix == ".corr":
            weights = np.asarray(found.weights, dtype=np.float64)
            lines = np.column_stack([ids, np.where(found.matched[:, None], weights, 0.0)])
            np.savetxt(temporary, lines, fmt="%d %.9g %.9g %.9g")
        elif suffix == ".csv":
            head = f"# {said}\nsource,target,confidence"
            table = np.column_stack([np.arange(len(ids)) + first, ids, sure])
            np.savetxt(temporary, table, fmt="%d,%d,%.6g", header=head, comments="")
        elif suffix == ".txt":
            head = f"{said}; the second column is the confidence"
            np.savetxt(temporary, np.column_stack([ids, sure]), fmt="%d %.6g", header=head, encoding="utf-8")
        else:
            np.savetxt(temporary, ids, fmt="%d")


def _word(name: str) -> str:
    """A name on one line, without the sign of comments."""
    return " ".join(name.replace("#", " ").split())

"""Tables of numbers in plain text: as many in every row, or refused with the line."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError


def number_rows(path: Path, columns: int, *, whole: bool = False) -> NDArray[np.float64]:
    """Rows of finite numbers separated by blanks or commas; any line ends, blank lines skipped.

    Parameters
    ----------
    path
    columns
        Numbers in a row.
    whole
        Whether they must be whole.

    Returns
    -------
    (n, columns) float64

    Raises
    ------
    InputError
        For the first line that is something else, or no lines.
    """
    try:
        text = path.read_bytes().decode("utf-8-sig", errors="replace")
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read: {error.strerror}") from error
    rows = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.replace(",", " ").split()
        if words:
            rows.append(_numbers(words, columns, whole, f"{str(path)!r}, line {number}"))
    if not rows:
        raise InputError(f"{str(path)!r} is empty; give {columns} numbers a line")
    return np.array(rows, dtype=np.float64)


def _numbers(words: list[str], columns: int, whole: bool, where: str) -> list[float]:
    """The words of one row as numbers."""
    if len(words) != columns:
        raise InputError(f"{where}, has {len(words)} columns, not {columns}; export the file again")
    try:
        row = [float(word) for word in words]
    except ValueError as error:
        raise InputError(f"{where}: {' '.join(words)!r} are no {columns} numbers; correct it") from error
    if not np.isfinite(row).all():
        raise InputError(f"{where}: {' '.join(words)!r} is not finite; correct it")
    if whole and any(value != round(value) for value in row):
        raise InputError(f"{where}: {' '.join(words)!r} are no indices; correct it")
    return row

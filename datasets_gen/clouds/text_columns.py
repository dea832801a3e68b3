"""Which column of a table is what: by their names, else by their number and by what is in them.

Colours and normals look alike in a text. Three columns are normals if nearly all their rows have unit
length, colours if they are whole numbers up to 255 or lie within 0..1; what is neither is refused.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from datasets_gen.clouds.column_names import COLOUR, NORMAL, POINT, UNUSED, as_names
from datasets_gen.clouds.point_cloud import Array, PointCloud
from datasets_gen.clouds.text_tables import NAME_COLUMNS, TextTable
from datasets_gen.records import InputError

UNIT = 0.02
"""How far from 1 the length of a normal may be: two decimals round by up to 0.009."""
FEWEST_NUMBERED = 3
"""Rows from which on a column that counts them is told from coordinates."""
MOST = 0.9
"""Share of the rows that must have unit length; zero and NaN do not count, as some programs write them."""


def columns_given(text: str | None) -> tuple[str, ...]:
    """Names of columns as a user gives them: ``"x y z nx ny nz"``, ``-`` for one to leave out.

    Raises
    ------
    InputError
        If they are no names, or x, y and z are not among them.
    """
    words = (text or "").replace(",", " ").split()
    names = tuple(each if each == UNUSED else (as_names([each, "x"]) or [each])[0] for each in words)
    if text is not None and not set(POINT) <= set(names):
        raise InputError(f'columns {text!r} do not name x, y and z; give them as "x y z nx ny nz"')
    return names


def as_cloud_of_columns(table: TextTable, where: str, columns: tuple[str, ...] = ()) -> PointCloud:
    """Points and normals of a table.

    Parameters
    ----------
    table
    where
        The file, for messages.
    columns
        Names that come before those of the file.

    Raises
    ------
    InputError
        If the columns cannot be told.
    """
    width = table.numbers.shape[1]
    names = columns or table.names
    if columns and len(columns) != width:
        raise InputError(
            f"{where}, line {_line(table, 0)}, has {width} columns, but {len(columns)} are named "
            f"({' '.join(columns)}); name each, - for one to leave out"
        )
    if not names:
        names, remarks = _told_by_content(table, where)
    else:
        remarks = _unused(names, "" if columns else " (by the file's names)")
    found = cloud_of_named(table.numbers, names, where)
    return replace(found, remarks=(*table.remarks, *remarks, *found.remarks))


def cloud_of_named(table: Array, names: Sequence[str], where: str) -> PointCloud:
    """Points and normals of columns (n, c) with names, as of `column_names`.

    Raises
    ------
    InputError
        If x, y or z is missing or a name stands twice.
    """
    place = {name: k for k, name in enumerate(names)}
    lacking = [name for name in POINT if name not in place]
    if lacking:
        raise InputError(
            f"{where} names the columns {' '.join(names)[:80]!r}, none of them {lacking[0]}; {NAME_COLUMNS}"
        )
    twice = next((name for name in (*POINT, *NORMAL) if list(names).count(name) > 1), None)
    if twice is not None:
        raise InputError(f"{where} names two columns {twice}; {NAME_COLUMNS}")
    points = table[:, [place[name] for name in POINT]]
    normals = [place[name] for name in NORMAL if name in place]
    if len(normals) in (1, 2):
        return PointCloud(points).remarked("normals with fewer than three components are not used")
    return PointCloud(points, table[:, normals] if normals else None)


def _unused(names: Sequence[str], how: str) -> list[str]:
    """A remark on columns that are not used."""
    other = [name for name in names if name not in (*POINT, *NORMAL, UNUSED)]
    return [f"columns that are not used{how}: {', '.join(other)}"] if other else []


def _told_by_content(table: TextTable, where: str) -> tuple[tuple[str, ...], list[str]]:
    """Names of columns without names, and what is to be said."""
    numbers, width = table.numbers, table.numbers.shape[1]
    if width == 3:
        return POINT, []
    if _counts_rows(numbers[:, 0]):
        raise InputError(
            f"{where}, line {_line(table, 0)}: the first of {width} columns counts the rows from "
            f'{numbers[0, 0]:g} and may be no coordinate; {NAME_COLUMNS} as "- x y z" if it is none'
        )
    if width == 4:
        return (*POINT, "intensity"), ["the fourth column is taken for an intensity and not used"]
    if width == 6:
        return _of_six(table, where)
    if width == 7:
        last = _kind(numbers[:, 4:])
        if last == "colours":
            return (*POINT, "intensity", *COLOUR), ["columns 4 to 7, intensity and colours, are not used"]
        if last == "normals":
            return (*POINT, "intensity", *NORMAL), ["columns 5 to 7 are taken for normals, of unit length"]
    if width == 9:
        kinds = (_kind(numbers[:, 3:6]), _kind(numbers[:, 6:]))
        if kinds == ("normals", "colours"):
            return (*POINT, *NORMAL, *COLOUR), ["columns 7 to 9 are colours and not used"]
        if kinds == ("colours", "normals"):
            return (*POINT, *COLOUR, *NORMAL), ["columns 4 to 6 are colours and not used"]
    raise InputError(
        f"{where}, line {_line(table, 0)}, has {width} columns, which can mean several things; "
        f'{NAME_COLUMNS} as "x y z nx ny nz"'
    )


def _counts_rows(column: Array) -> bool:
    """Whether a column is 0, 1, 2 ... or 1, 2, 3 ..., as programs number points."""
    return len(column) >= FEWEST_NUMBERED and any(
        np.array_equal(column, np.arange(first, first + len(column))) for first in (0, 1)
    )


def _of_six(table: TextTable, where: str) -> tuple[tuple[str, ...], list[str]]:
    kind = _kind(table.numbers[:, 3:])
    if kind == "colours":
        return (*POINT, *COLOUR), ["columns 4 to 6 are colours, not normals, and not used"]
    if kind == "normals":
        positive = len(table.numbers) > 0 and not (table.numbers[:, 3:] < 0).any()
        return (*POINT, *NORMAL), (
            ["columns 4 to 6 have unit length and are taken for normals, though none is negative"]
            if positive
            else []
        )
    wrong = int((~_unit(table.numbers[:, 3:])).argmax())
    triple = " ".join(f"{value:g}" for value in table.numbers[wrong, 3:])
    raise InputError(
        f"{where}, line {_line(table, wrong)}: columns 4 to 6 ({triple}) are neither normals of unit length "
        f'nor colours; {NAME_COLUMNS} as "x y z nx ny nz"'
    )


def _unit(triples: Array) -> NDArray[np.bool_]:
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray(np.abs(np.linalg.norm(triples, axis=1) - 1) <= UNIT)


def _kind(triples: Array) -> str:
    """What three columns hold: ``"normals"``, ``"colours"`` or neither."""
    with np.errstate(over="ignore", invalid="ignore"):
        blank = ~np.isfinite(triples).all(axis=1) | (triples == 0).all(axis=1)
    rest = triples[~blank]
    if not len(rest):
        return "normals" if not len(triples) or not np.isfinite(triples).all() else "colours"
    if _unit(rest).mean() >= MOST:
        return "normals"
    whole = (rest == np.round(rest)).all()
    inside = rest.min() >= 0 and rest.max() <= (255 if whole else 1)
    return "colours" if inside else ""


def _line(table: TextTable, row: int) -> int:
    return int(table.lines[row]) if len(table.lines) else 1

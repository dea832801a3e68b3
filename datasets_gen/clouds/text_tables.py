"""Rows of numbers in a text: separators, decimal commas, names and counts, understood or refused."""

import re
from codecs import BOM_UTF8, BOM_UTF16_BE, BOM_UTF16_LE
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from datasets_gen.clouds.column_names import as_names
from datasets_gen.records import InputError

COMMENTS = ("#", "//", "%")
DECIMAL = re.compile(r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?")
WHOLE = re.compile(r"[-+]?\d+(?:,0*)?")
NAME_COLUMNS = "name the columns in a first line, or with --columns"

Line = tuple[int, str]
"""Number of a line, counted from 1, and its text."""


@dataclass(frozen=True)
class TextTable:
    """Numbers (n, c) of a text, the lines that they stand in (n,), and names (c) where the file has them."""

    numbers: NDArray[np.float64]
    lines: NDArray[np.int64]
    names: tuple[str, ...]
    remarks: tuple[str, ...]


def read_table(path: Path, columns: int = 0) -> TextTable:
    """Read a text of numbers in columns.

    Comments begin with ``#``, ``//`` or ``%``; one of them may name the columns, as may the first line. A
    line with a whole number alone is the number of rows that follow.

    Parameters
    ----------
    path
    columns
        How many the user has named, if any.

    Raises
    ------
    InputError
        With the line, for what is no table of numbers or can be read in two ways.
    """
    named, lines = _parts(_text(path))
    _check_cells(path, lines)
    names: list[str] = []
    if lines and not _all_numbers(re.split(r"[\s,;]+", lines[0][1].strip(" \t,;"))):
        names = as_names(_quoted(lines[0][1]))
        if not names:
            raise InputError(
                f"{str(path)!r}, line {lines[0][0]}, is no row of numbers{_first_wrong(lines[0])}"
            )
        lines = lines[1:]
    rows, separator = _fields(path, _counted(path, lines), columns or len(names) or len(named))
    width = len(rows[0][1]) if rows else 0
    for number, words in rows:
        if len(words) != width:
            raise InputError(
                f"{str(path)!r}, line {number}, has {len(words)} columns, the first line {width}; "
                "give as many in each"
            )
    if not names and len(named) == width:
        names = named
    if names and rows and len(names) != width:
        raise InputError(
            f"{str(path)!r}, line {rows[0][0]}, has {width} columns, but {len(names)} are named; "
            "give a name for each"
        )
    table = np.array([_numbers(path, number, words) for number, words in rows]).reshape(-1, width or 3)
    numbers = np.array([number for number, _ in rows], dtype=np.int64)
    return TextTable(table, numbers, tuple(names), tuple(separator))


def _text(path: Path) -> str:
    """The text of a file; one that is no UTF-8 is Latin-1, in which every byte is a letter."""
    content = path.read_bytes()
    if content.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        return content.decode("utf-16", "replace")
    zero = content.find(b"\0")
    if zero >= 0:
        line = content[:zero].count(b"\n") + 1
        raise InputError(f"{str(path)!r}, line {line}, is no text (byte {zero}); give columns of numbers")
    content = content.removeprefix(BOM_UTF8)
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _parts(text: str) -> tuple[list[str], list[Line]]:
    """Names that a comment gives, and the other lines."""
    names, lines = list[str](), list[Line]()
    for number, line in enumerate(re.split(r"\r\n|\n|\r", text), 1):
        plain = line.strip()
        mark = next((each for each in COMMENTS if plain.startswith(each)), None)
        if mark is not None:
            found = as_names(_quoted(plain.lstrip("#/% \t")))
            names = found if not lines and found[:3] == ["x", "y", "z"] else names
        elif plain.strip(",; \t"):
            lines.append((number, plain))
    return names, lines


def _check_cells(path: Path, lines: list[Line]) -> None:
    """Raise for a cell between separators that is empty: the numbers after it would move one column."""
    for number, line in lines:
        if re.search(r"[,;]\s*[,;]", line.strip(",; \t")):
            raise InputError(
                f"{str(path)!r}, line {number}, has an empty cell: {line[:40]!r}; "
                "write nan in it, or remove the column"
            )


def _quoted(line: str) -> list[str]:
    """Words of a line of names."""
    parts = re.split(r"[,;\t]+" if re.search(r"[,;\t]", line) else r"\s+", line.strip(" \t,;"))
    return [part.strip().strip("\"'").strip() for part in parts]


def _all_numbers(words: list[str]) -> bool:
    return all(_is_number(word) for word in words if word)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _first_wrong(line: Line) -> str:
    words = re.split(r"[\s,;]+", line[1].strip(" \t,;"))
    wrong = next((word for word in words if not _is_number(word)), "")
    return f" ({wrong[:40]!r}), nor of names such as x y z; give numbers"


def _counted(path: Path, lines: list[Line]) -> list[Line]:
    """The lines without those that say how many rows follow, which is checked."""
    if not lines or not re.fullmatch(r"\d{1,18}", lines[0][1]):
        return lines
    out, place = list[Line](), 0
    while place < len(lines):
        number, text = lines[place]
        if not re.fullmatch(r"\d{1,18}", text):
            raise InputError(
                f"{str(path)!r}, line {number}, is one row more than the number of rows before it says; "
                "correct that number"
            )
        rows = lines[place + 1 : place + 1 + int(text)]
        if len(rows) < int(text):
            raise InputError(
                f"{str(path)!r}, line {number}, says {int(text)} rows, but {len(rows)} follow; "
                "the file is cut short: export it again"
            )
        out += rows
        place += 1 + int(text)
    return out


def _fields(path: Path, lines: list[Line], named: int) -> tuple[list[tuple[int, list[str]]], list[str]]:
    """The words of each line, and remarks, by what separates them in the whole file.

    A comma is a decimal one where a semicolon or blanks separate, each word has one at most, and no point is
    there.
    """
    texts = [text for _, text in lines]
    if not any("," in text for text in texts):
        return [(number, re.split(r"[\s;]+", text.strip(" \t;"))) for number, text in lines], []
    points, semicolons = any("." in text for text in texts), any(";" in text for text in texts)
    if points and semicolons and any(DECIMAL.search(text) for text in texts):
        at = next(number for number, text in lines if DECIMAL.search(text))
        raise InputError(
            f"{str(path)!r}, line {at}, has commas within semicolons where other numbers have points; "
            "write all numbers with a point"
        )
    blank = [re.split(r"[\s;]+", text.strip(" \t;")) for text in texts]
    decimal = not points and all(word.count(",") <= 1 for words in blank for word in words)
    decimal = decimal and not any(word.startswith(",") or word.endswith(",") for w in blank for word in w)
    if decimal and min(len(words) for words in blank) >= 2:
        out = [
            (number, [w.replace(",", ".") for w in words])
            for (number, _), words in zip(lines, blank, strict=True)
        ]
        return out, ["decimal commas are read as points"]
    out = [(number, re.split(r"[\s,;]+", text.strip(" \t,;"))) for number, text in lines]
    width = len(out[0][1])
    if not points and width % 2 == 0 and width >= 6 and named != width and len(blank[0]) == 1:
        raise InputError(
            f"{str(path)!r}, line {lines[0][0]}, can be read in two ways: {texts[0][:40]!r} is {width} whole "
            f"numbers or {width // 2} with decimal commas; {NAME_COLUMNS}, or write numbers with a point"
        )
    return out, []


def _numbers(path: Path, line: int, words: list[str]) -> list[float]:
    """Words of a line as numbers; NaN and infinity are some."""
    try:
        if any("_" in word for word in words):
            raise ValueError(f"{next(word for word in words if '_' in word)[:40]!r}")
        return [float(word) for word in words]
    except ValueError as error:
        said = str(error)[:80]
        raise InputError(f"{str(path)!r}, line {line}, is no row of numbers ({said}); correct it") from error

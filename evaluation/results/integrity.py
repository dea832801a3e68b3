"""Whether stored results are what was written: checksums of files and of notes about them.

CRC-32, as in a zip archive: it finds damage, not forgery, at 3.8 GB/s; BLAKE2b takes four times as long.
"""

import json
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from datasets_gen.parsing import parsed_json
from datasets_gen.records import file_content, no_file

SEAL = "checksum"
"""Entry of a note that holds the checksum of all others."""
CHUNK = 1 << 20
NAMED = 5
"""Damaged results named in one line."""


def checksum(path: Path) -> int:
    """CRC-32 of a file's bytes; OSError if it cannot be read, or is a pipe or a device."""
    if what := no_file(path):
        raise OSError(f"it {what}")
    found = 0
    with path.open("rb") as stream:
        while chunk := stream.read(CHUNK):
            found = zlib.crc32(chunk, found)
    return found


def sealed(note: Mapping[str, Any]) -> dict[str, Any]:
    """The note with the checksum of its values."""
    plain = json.loads(json.dumps(note))  # as it will be read
    return {**plain, SEAL: _seal(plain)}


def unsealed(path: Path, keys: Iterable[str] | None = None) -> dict[str, Any]:
    """The note in a JSON file.

    Parameters
    ----------
    path
    keys
        What notes without a checksum have, as earlier versions wrote them; None if that is not known.

    Raises
    ------
    OSError
        If there is no such file.
    ValueError
        If it is not as it was written.
    """
    note = parsed_json(file_content(path), repr(str(path)))
    if not isinstance(note, dict):
        raise ValueError("it holds no table")
    if SEAL in note:
        seal = note.pop(SEAL)
        if seal != _seal(note):
            raise ValueError("its checksum is another one")
    elif keys is not None and set(note) != set(keys):
        raise ValueError("its checksum is missing")
    return note


def _seal(note: Mapping[str, Any]) -> int:
    return zlib.crc32(json.dumps(note, sort_keys=True, separators=(",", ":")).encode())


def damage_of_archive(path: Path) -> str:
    """What is wrong with an ``.npz`` file by the checksums of its arrays; empty if nothing."""
    try:
        with ZipFile(path) as file:
            wrong = file.testzip()
    except Exception as error:  # a damaged archive makes its reader raise anything
        return str(error) or type(error).__name__
    return f"array {wrong!r} has another checksum" if wrong else ""


def damage_line(damaged: Mapping[str, str]) -> str:
    """One line that says which results are damaged, and that they are made again."""
    shown = [f"{name} ({why})" for name, why in list(damaged.items())[:NAMED]]
    more = [f"{len(damaged) - NAMED} more"] if len(damaged) > NAMED else []
    return f"damaged results are made again: {', '.join([*shown, *more])}"

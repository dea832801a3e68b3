"""Texts that people write, TOML and JSON, with one kind of error; and notes of the program to itself."""

import json
import tomllib
from pathlib import Path
from types import UnionType
from typing import Any

from datasets_gen.records import InputError, file_content


def parsed_toml(content: str | bytes, where: str) -> dict[str, Any]:
    """The tables of a TOML text.

    Parameters
    ----------
    content
        Bytes are taken for UTF-8.
    where
        What the text is, for the message.

    Raises
    ------
    InputError
        If it is no TOML, no UTF-8, or nested so deeply that it cannot be read.
    """
    try:
        return tomllib.loads(content if isinstance(content, str) else content.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where} is not valid TOML: {_why(error)}; correct it") from error


def parsed_json(content: str | bytes, where: str) -> Any:
    """The value of a JSON text; as `parsed_toml`."""
    try:
        return json.loads(content if isinstance(content, str) else content.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where} is not readable JSON ({_why(error)}); correct or remove it") from error


def read_note(path: Path, **types: type | UnionType) -> dict[str, Any] | None:
    """What the program noted for itself in a small JSON file; None if it is to be made again.

    Parameters
    ----------
    path
    **types
        Of the entries that the note must have, by name; it may have others.

    Returns
    -------
    dict or None
        None if the file is missing or damaged, or lacks an entry or has one of another type.
    """
    try:
        note = parsed_json(file_content(path), repr(str(path)))
    except (OSError, InputError):
        return None
    whole = isinstance(note, dict) and all(isinstance(note.get(name), kind) for name, kind in types.items())
    return note if whole else None


def _why(error: Exception) -> str:
    """One line."""
    if isinstance(error, RecursionError):
        return "lists or tables are nested too deeply"
    return " ".join(str(error).split())

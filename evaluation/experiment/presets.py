"""The packaged experiments, and reading a preset or a TOML file."""

import os
from collections.abc import Callable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from datasets_gen.parsing import parsed_toml
from datasets_gen.records import InputError, file_content
from evaluation.experiment.toml_tables import reject_unknown


def packaged_toml(package: str) -> dict[str, str]:
    """Text of every TOML file of a package, by name."""
    found = [each for each in files(package).iterdir() if each.name.endswith(".toml")]
    return {
        each.name.removesuffix(".toml"): each.read_text(encoding="utf-8") for each in sorted(found, key=str)
    }


def presets() -> dict[str, str]:
    """Text (TOML) of every packaged experiment, by name."""
    return packaged_toml("evaluation.protocols")


def preset_or_file(
    source: str | os.PathLike[str],
    known: Mapping[str, str],
    what: str,
    locate: Callable[[dict[str, Any], Path], None],
) -> tuple[dict[str, Any], str]:
    """The table of a preset by name or of a TOML file by path.

    Parameters
    ----------
    source
    known
        Text of each preset.
    what
        ``"experiment"``, say, for messages.
    locate
        Makes paths of a table absolute, given the folder of its file.

    Returns
    -------
    table
        Named like the preset or the file where it has no ``name``.
    where
        For messages.

    Raises
    ------
    InputError
        If there is no such preset or file, or it is no TOML.
    """
    path = Path(source)
    if path.suffix != ".toml":
        reject_unknown([str(source)], known, what, "preset")
        where = f"preset {str(source)!r}"
        return {"name": path.stem, **parsed_toml(known[str(source)].encode(), where)}, where
    try:
        text, where = file_content(path), repr(str(source))
    except OSError as error:
        raise InputError(
            f"cannot read {str(source)!r}: {error.strerror}; presets: {', '.join(known)}"
        ) from error
    table = {"name": path.stem, **parsed_toml(text, where)}
    locate(table, path.parent)
    return table, where

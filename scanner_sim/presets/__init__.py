"""Settings of known scanners, as TOML files beside this module or anywhere else.

A file has a table ``[scanner]`` with fields of `ScannerConfig`, and a table ``[about]`` with free text: what
the device is, where the figures come from, what its data sheet says, and what was chosen where it is silent.
`ScannerConfig.preset` makes a scanner of them.
"""

import os
from collections.abc import Collection, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from datasets_gen.parsing import parsed_toml
from datasets_gen.records import InputError, file_content
from datasets_gen.values import did_you_mean

KEY = "preset"
"""Setting that names a preset among other settings."""


def names() -> list[str]:
    """Names of the presets that come with the package, sorted."""
    found = (entry.name for entry in files(__name__).iterdir() if entry.name.endswith(".toml"))
    return sorted(name.removesuffix(".toml") for name in found)


def load(name: str | os.PathLike[str], known: Collection[str] = ()) -> dict[str, Any]:
    """Settings of a preset, by field of `ScannerConfig`.

    Parameters
    ----------
    name
        One of `names`, or the path of a file that ends in ``.toml``.
    known
        Names that settings may have; not checked if there are none.

    Raises
    ------
    InputError
        If there is no such preset or file, or it has unknown or no settings.
    """
    table = _read(name)
    unknown = sorted(set(table) - {"about", "scanner"})
    if unknown or not isinstance(table.get("scanner"), dict):
        wrong = f"has {unknown[0]!r} outside [scanner]" if unknown else "lacks a table [scanner]"
        raise InputError(f"preset {str(name)!r} {wrong}; it needs [scanner], and may have [about]")
    settings: dict[str, Any] = table["scanner"]
    for key in sorted(set(settings) - set(known)) if known else ():
        raise InputError(
            f"preset {str(name)!r} has an unknown setting {key!r}{did_you_mean(key, known)} "
            f"known settings are {', '.join(sorted(known))}"
        )
    return settings


def about(name: str | os.PathLike[str]) -> dict[str, Any]:
    """What a preset's file says of its device and its sources; empty if nothing.

    Raises
    ------
    InputError
        If there is no such preset or file.
    """
    found = _read(name).get("about", {})
    return dict(found) if isinstance(found, Mapping) else {"name": str(found)}


def expanded(settings: Mapping[str, Any], known: Collection[str] = ()) -> dict[str, Any]:
    """Settings in which ``preset``, if there is one, is replaced by its settings; the others go before them.

    Parameters
    ----------
    settings
        Fields of `ScannerConfig`, and maybe ``preset``.
    known
        Names that settings of the preset may have, as for `load`.

    Raises
    ------
    InputError
        If the preset is unknown or has an unknown setting.
    """
    if KEY not in settings:
        return dict(settings)
    name = settings[KEY]
    if not isinstance(name, str | os.PathLike):
        raise InputError(f"preset must be a name or the path of a .toml file, got {name!r}")
    return load(name, known) | {key: value for key, value in settings.items() if key != KEY}


def _read(name: str | os.PathLike[str]) -> dict[str, Any]:
    """Tables of a preset's file."""
    path = Path(name)
    if path.suffix.lower() == ".toml":
        try:
            content = file_content(path)
        except OSError as error:
            reason = error.strerror or str(error)
            raise InputError(f"cannot read the preset {str(name)!r}: {reason}") from error
    elif str(name) in names():
        content = (files(__name__) / f"{name}.toml").read_bytes()
    else:
        raise InputError(
            f"unknown preset {str(name)!r}{did_you_mean(str(name), names())} known presets are "
            f"{', '.join(names())}, or give the path of a .toml file"
        )
    return parsed_toml(content, f"preset {str(name)!r}")

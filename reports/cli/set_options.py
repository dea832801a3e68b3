"""NAME=VALUE options."""

import tomllib
from typing import Any

import click


def parsed(settings: tuple[str, ...]) -> dict[str, Any]:
    """Pairs as a table; values are read as TOML, or else taken as text.

    Raises
    ------
    click.UsageError
        If one has no name or no value.
    """
    table: dict[str, Any] = {}
    for setting in settings:
        name, equals, value = (part.strip() for part in setting.partition("="))
        if not equals or not name:
            raise click.UsageError(f"--set takes NAME=VALUE, got {setting!r}")
        try:
            table[name] = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            table[name] = value
    return table

"""NAME=VALUE options."""

import re
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import click

LEADING, TRAILING = re.compile(r"(?<![\w.])\.(?=\d)"), re.compile(r"(?<=\d)\.(?![\w.])")
"""Points of numbers as people write them, ``.5`` and ``1.``; TOML wants digits on both sides."""


def value_of(text: str) -> Any:
    """What a text stands for: a value of TOML, with numbers such as ``.5`` and ``1.``, or JSON, or itself."""
    from datasets_gen.parsing import parsed_json, parsed_toml
    from datasets_gen.records import InputError

    text = text.strip()
    for attempt in (text, TRAILING.sub(".0", LEADING.sub("0.", text))):
        with suppress(InputError):
            return parsed_toml(f"value = {attempt}", "a value")["value"]
    try:
        return parsed_json(text, "a value")
    except InputError:
        return text


def parsed(settings: tuple[str, ...]) -> dict[str, Any]:
    """Pairs as a table of values (`value_of`).

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
        table[name] = value_of(value)
    return table


def merged(named: Mapping[str, Any], settings: tuple[str, ...]) -> dict[str, Any]:
    """Settings that have an option of their own, and those given with ``--set``.

    Parameters
    ----------
    named
        Value by the name of the setting; its option has the same name with hyphens. None: not given.
    settings
        NAME=VALUE pairs.

    Raises
    ------
    click.UsageError
        If a pair is malformed, or sets what its own option sets, too.
    """
    given, table = {name: value for name, value in named.items() if value is not None}, parsed(settings)
    for name in given:
        if name in table:
            option = f"--{name.replace('_', '-')} {given[name]}"
            raise click.UsageError(
                f"{option!r} and '--set {name}={table[name]}' both set {name}; give one of them"
            )
    return given | table

"""NAME=VALUE options, and the list of the names that a command takes."""

import re
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Literal, get_args, get_origin

import click

from reports.cli.console import Command, Failure, reason, result_console

if TYPE_CHECKING:
    from reports.cli.setting_list import Setting

LEADING, TRAILING = re.compile(r"(?<![\w.])\.(?=\d)"), re.compile(r"(?<=\d)\.(?![\w.])")
"""Points of numbers as people write them, ``.5`` and ``1.``; TOML wants digits on both sides."""


class CommandWithSettings(Command):
    """A command that takes ``--set NAME=VALUE`` and lists the names with ``--settings``.

    Parameters
    ----------
    listed
        The settings, by the options that were given (None where one was not).
    about
        What can be set, for the help.
    """

    def __init__(
        self,
        *args: Any,
        listed: "Callable[[Mapping[str, Any]], list[Setting]]",
        about: str,
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        self._listed = listed
        self.params += [
            click.Option(
                ["--set", "settings"],
                multiple=True,
                metavar="NAME=VALUE",
                help=f"{about}; may be repeated. --settings lists the names.",
            ),
            click.Option(
                ["--settings", "list_settings"],
                is_flag=True,
                expose_value=False,
                help="List what --set takes, with types and defaults, and end.",
            ),
        ]

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """List the settings if that is wanted, whatever arguments are missing."""
        if "--settings" in args:
            given: dict[str, Any] = self.make_parser(ctx).parse_args(list(args))[0]
            if given.get("list_settings"):
                self._print(given)
                ctx.exit()
        return super().parse_args(ctx, args)

    def _print(self, given: Mapping[str, Any]) -> None:
        from reports.cli.setting_list import settings_table

        try:
            result_console().print(settings_table(self._listed(given)))
        except ValueError as error:
            raise Failure(reason(error)) from error


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


def parsed(given: tuple[str, ...], settings: "Collection[Setting]" = ()) -> dict[str, Any]:
    """Pairs as a table of values (`value_of`).

    Parameters
    ----------
    given
        NAME=VALUE pairs.
    settings
        Those whose type is known: lists may be given without brackets and quotes, as ``visibility,strain``,
        and where words are to choose from, ``true`` is the word.

    Raises
    ------
    click.UsageError
        If one has no name or no value.
    """
    lists = {each.name for each in settings if get_origin(each.hint) is tuple}
    words = {each.name: get_args(each.hint) for each in settings if get_origin(each.hint) is Literal}
    table: dict[str, Any] = {}
    for setting in given:
        name, equals, value = (part.strip() for part in setting.partition("="))
        if not equals or not name:
            raise click.UsageError(f"--set takes NAME=VALUE, got {setting!r}")
        found = value if value in words.get(name, ()) else value_of(value)
        if name in lists and not isinstance(found, list):
            found = [value_of(part) for part in value.split(",") if part.strip()]
        table[name] = found
    return table


def merged(
    named: Mapping[str, Any], given: tuple[str, ...], settings: "Collection[Setting]" = ()
) -> dict[str, Any]:
    """Settings that have an option of their own, and those given with ``--set``.

    Parameters
    ----------
    named
        Value by the name of the setting; its option has the same name with hyphens. None: not given.
    given, settings
        As for `parsed`.

    Raises
    ------
    click.UsageError
        If a pair is malformed, or sets what its own option sets, too.
    """
    options = {name: value for name, value in named.items() if value is not None}
    table = parsed(given, settings)
    for name in options:
        if name in table:
            option = f"--{name.replace('_', '-')} {options[name]}"
            raise click.UsageError(
                f"{option!r} and '--set {name}={table[name]}' both set {name}; give one of them"
            )
    return options | table

"""The settings of a class: names, types, defaults and what they mean, read from its code."""

import ast
import inspect
import re
import textwrap
from collections.abc import Collection, Iterable
from dataclasses import MISSING, Field, dataclass, fields
from itertools import pairwise
from typing import TYPE_CHECKING, Any, get_type_hints

if TYPE_CHECKING:
    from rich.table import Table

END = re.compile(r"(?<!\bEq)(?<!\bEqs)(?<!\bSec)\. (?=[A-Z\"])")
"""Of a sentence."""


@dataclass(frozen=True)
class Setting:
    """A field of a dataclass of settings.

    Attributes
    ----------
    name : str
    hint
        Its type.
    default : str
        As it would be written after ``--set NAME=``; empty if there is none.
    about : str
        The first sentence of what the class says about it.
    """

    name: str
    hint: Any
    default: str
    about: str

    @property
    def takes(self) -> str:
        """What values may be, in words."""
        from datasets_gen.values import type_words

        try:
            return type_words(self.hint)
        except KeyError:  # types with a form of their own, as viewpoints
            return "see the meaning"


def settings_of(cls: type, leave_out: Collection[str] = ()) -> list[Setting]:
    """The settings of a dataclass, in its order.

    Parameters
    ----------
    cls
    leave_out
        Names of fields that are not set one by one.
    """
    about: dict[str, str] = {}
    for each in reversed(cls.__mro__):
        about |= _meanings(each)
    hints = get_type_hints(cls)
    return [
        Setting(each.name, hints[each.name], _default(each), about.get(each.name, ""))
        for each in fields(cls)
        if each.name not in leave_out
    ]


def settings_table(settings: Iterable[Setting]) -> "Table":
    """A table for the terminal."""
    from rich.markup import escape
    from rich.table import Table

    table = Table("setting", "default", "value", "meaning", box=None, pad_edge=False)
    for each in settings:
        table.add_row(*(escape(text) for text in (each.name, each.default, each.takes, each.about)))
    return table


def _meanings(cls: type) -> dict[str, str]:
    """First sentence of the docstring after each field of a class; none where the code cannot be read."""
    try:
        body = ast.parse(textwrap.dedent(inspect.getsource(cls))).body[0]
    except (OSError, TypeError, SyntaxError):
        return {}
    found = {}
    lines = getattr(body, "body", [])
    for line, after in pairwise(lines):
        if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name):
            said = after.value if isinstance(after, ast.Expr) else None
            found[line.target.id] = _sentence(str(said.value)) if isinstance(said, ast.Constant) else ""
    return found


def _sentence(text: str) -> str:
    """The first sentence, without the marks of the documentation."""
    plain = " ".join(text.split()).replace("``", "").replace("`", "")
    return END.split(plain)[0].removesuffix(".")


def _default(field: "Field[Any]") -> str:
    value = field.default
    if value is MISSING:
        value = field.default_factory() if field.default_factory is not MISSING else ""
    if isinstance(value, tuple | list):
        return ",".join(map(str, value))
    if value is None or isinstance(value, bool):
        return "null" if value is None else str(value).lower()
    return str(value)

"""Checks of the values that users give: counts, seeds, the types of settings, and arrays of numbers."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from difflib import get_close_matches
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Any, ClassVar, Literal, Self, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError

_WORDS: dict[Any, str] = {
    bool: "true or false",
    int: "a whole number",
    float: "a finite number",
    str: "text",
    NoneType: "None",
}


def check_count(value: Any, name: str, least: int = 1, most: int | None = None) -> int:
    """The value as an int; NumPy's whole numbers count, 5.0 and True do not.

    Parameters
    ----------
    value
    name
        Of the value, for the message.
    least
        Smallest value that is accepted.
    most
        Largest one, if there is one.

    Raises
    ------
    InputError
        If it is no whole number of at least `least` and at most `most`.
    """
    if not _fits(value, int) or value < least:
        raise InputError(f"{name} is {value!r}; give a whole number of at least {least}")
    if most is not None and value > most:
        raise InputError(f"{name} is {value!r}; give a whole number of at most {most}")
    return int(value)


def check_seed(seed: Any, name: str = "seed") -> int:
    """The seed as an int; InputError unless it is a whole number of at least 0."""
    return check_count(seed, name, 0)


def check_types(cls: Callable[..., Any], values: Mapping[str, Any], what: str = "") -> None:
    """Check the types of settings against the annotations of their class, or of a function.

    Whole numbers are numbers, too; truth values are none, and texts such as "false" are no truth values. What
    is annotated with anything but plain types, ``Literal``, tuples and mappings of these is not looked at.

    Parameters
    ----------
    cls
    values
        By name; names that the class does not have are not looked at.
    what
        Kind of setting, for the message.

    Raises
    ------
    InputError
        For the first value of another type.
    """
    try:
        hints = get_type_hints(cls)
    except NameError:  # of a user's class that names types of imports for type checkers
        return
    for name, hint in hints.items():
        if name in values and not _fits(values[name], hint):
            raise InputError(f"{what} {name} must be {type_words(hint)}, got {values[name]!r}".lstrip())


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """The known name that is most similar, as ``; did you mean 'views'?``; a semicolon if none is similar."""
    close = get_close_matches(name, list(known), n=1, cutoff=0.5)
    return f"; did you mean {close[0]!r}?" if close else ";"


class CheckedSettings:
    """Base of frozen dataclasses of settings, which raise InputError for names that they do not know."""

    kind: ClassVar[str] = "setting"
    """What one of them is called in messages."""

    def __new__(cls, **given: Any) -> Self:
        """Check the names."""
        known = [each.name for each in fields(cls)]  # type: ignore[arg-type]
        for name in given:
            if name not in known:
                hint = did_you_mean(name, known)
                raise InputError(f"unknown {cls.kind} {name!r}{hint} known are {', '.join(known)}")
        return super().__new__(cls)

    def check_types(self) -> None:
        """Check the types of all fields (`check_types`)."""
        check_types(type(self), vars(self), self.kind)


def _fits(value: Any, hint: Any) -> bool:
    kind, parts = get_origin(hint) or hint, get_args(hint)
    if kind is UnionType:
        return any(_fits(value, part) for part in parts)
    if kind is Literal:
        return any(type(value) is type(part) and value == part for part in parts)
    if kind is tuple:
        fixed = Ellipsis not in parts
        return (
            isinstance(value, tuple | list)
            and all(_fits(each, parts[0]) for each in value)
            and not (fixed and len(value) != len(parts))
        )
    if kind is Mapping:
        return isinstance(value, Mapping)
    if kind is int or kind is float:
        number = isinstance(value, Integral if kind is int else Real) and not isinstance(value, bool)
        return number and (kind is int or _is_finite(value))
    return kind not in _WORDS or isinstance(value, kind)


def _is_finite(value: Any) -> bool:
    """Whether a number is a finite float; whole numbers of hundreds of digits are none."""
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


def type_words(hint: Any) -> str:
    """What a value of a type that `check_types` looks at has to be: ``a whole number or None``."""
    kind, parts = get_origin(hint) or hint, get_args(hint)
    if kind is UnionType:
        return " or ".join(type_words(part) for part in parts)
    if kind is Literal:
        return f"one of {', '.join(map(repr, parts))}"
    if kind is tuple and Ellipsis not in parts:
        return f"a list of {len(parts)}, each {type_words(parts[0])}"
    if kind is tuple:
        simple = parts[0] in _WORDS or get_origin(parts[0]) is Literal
        return f"a list, each {type_words(parts[0])}" if simple else "a list"
    return "a table" if kind is Mapping else _WORDS[kind]


def real_array(given: Any, name: str) -> NDArray[np.float64]:
    """The array as float64; the same object if it is one.

    Raises
    ------
    InputError
        If it is no array of numbers, or of complex ones: their imaginary parts would be lost.
    """
    try:
        if np.iscomplexobj(given):
            raise InputError(f"{name} has complex numbers; give real ones")
        return np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{name} must be an array of numbers ({error})") from error

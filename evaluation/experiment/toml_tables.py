"""TOML tables to frozen dataclasses, with errors that name the key and the nearest valid one; and to text."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Any, TypeVar

from datasets_gen.records import InputError
from datasets_gen.values import check_types, did_you_mean

T = TypeVar("T")


def reject_unknown(given: Iterable[str], known: Iterable[str], where: str, what: str = "key") -> None:
    """Raise unless every given name is known.

    Raises
    ------
    InputError
        Names the place, the unknown name, the nearest valid one and all that are valid.
    """
    valid = sorted(known)
    for name in given:
        if name not in valid:
            hint = did_you_mean(str(name), valid)
            raise InputError(f"{where}: unknown {what} {name!r}{hint} valid: {', '.join(valid)}")


def dataclass_from_table(cls: type[T], table: Any, where: str) -> T:
    """A frozen dataclass from a table; unknown keys, missing ones and values of another type are errors.

    Raises
    ------
    InputError
        If `table` is no table, or a key is unknown or missing, or a value is of another type or refused.
    """
    if not isinstance(table, Mapping):
        raise InputError(f"{where} must be a table, got {table!r}")
    reject_unknown(table, [f.name for f in fields(cls)], where)  # type: ignore[arg-type]
    try:
        check_types(cls, table)
        return cls(**table)
    except TypeError as error:
        raise InputError(f"{where}: {str(error).split(') ')[-1]}") from error
    except InputError as error:
        raise InputError(f"{where}: {error}") from error


def expect(condition: bool, message: str) -> None:
    """Raise `InputError` unless a condition holds."""
    if not condition:
        raise InputError(message)


def expect_distinct(values: Sequence[Any], what: str) -> None:
    """Raise `InputError` if there are no values, or one is there twice: its tasks would be counted twice."""
    expect(len(values) > 0, f"{what} is empty; give at least one, or leave it out")
    for value in values:
        expect(values.count(value) == 1, f"{what} has {value!r} {values.count(value)} times; give it once")


def to_toml(table: Mapping[str, Any]) -> str:
    """A table as TOML that `tomllib` reads back; None is left out, as TOML has no word for it."""
    import tomli_w

    return tomli_w.dumps(_without_none(table))


def _without_none(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _without_none(each) for key, each in value.items() if each is not None}
    if isinstance(value, list | tuple):
        return [_without_none(each) for each in value]
    return value

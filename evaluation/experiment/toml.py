"""Writing TOML; the standard library only reads it."""

import json
from collections.abc import Mapping
from typing import Any


def dumps(table: Mapping[str, Any]) -> str:
    """A table as TOML that `tomllib` reads back. None is left out, as TOML has no word for it."""
    return "\n".join(_lines(table, "")) + "\n"


def _lines(table: Mapping[str, Any], prefix: str) -> list[str]:
    """Values first, then tables: what follows a header belongs to it."""
    plain, nested = [], []
    for key, value in table.items():
        name = f"{prefix}{_key(key)}"
        if value is None:
            continue
        if isinstance(value, Mapping) and not _short(value):
            nested += ["", f"[{name}]", *_lines(value, f"{name}.")]
        elif isinstance(value, list | tuple) and value and all(isinstance(each, Mapping) for each in value):
            for each in value:
                nested += ["", f"[[{name}]]", *_lines(each, f"{name}.")]
        else:
            plain.append(f"{_key(key)} = {_value(value)}")
    return plain + nested


def _short(value: Mapping[str, Any]) -> bool:
    """Tables of plain values stand on one line."""
    return len(value) <= 8 and all(not isinstance(v, Mapping | list | tuple) for v in value.values())


def _key(key: str) -> str:
    return key if key and all(c.isascii() and (c.isalnum() or c in "-_") for c in key) else json.dumps(key)


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return (
            "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items() if v is not None) + " }"
            if value
            else "{}"
        )
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(each) for each in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(value)
    return json.dumps(str(value), ensure_ascii=False)

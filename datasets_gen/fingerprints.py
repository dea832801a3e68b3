"""What a task is: keys, seeds and the version of the code that matters to it.

A result may be used again only if nothing that made it has changed. The key of a task is therefore a hash
of its settings, of the keys of its inputs and of the source of every project module that its stage can
reach through imports. Comments, docstrings and layout do not count; a change in a metric reaches scores,
not scans.
"""

import ast
import hashlib
import json
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

PROJECT = ("datasets_gen", "scanner_sim", "medial", "evaluation")


def canonical(value: Any) -> str:
    """One text for one value: JSON with sorted keys; 1.0 and 1 are the same number."""
    return json.dumps(_plain(value), sort_keys=True, separators=(",", ":"), allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float) and value.is_integer():
        return int(value)
    return value


def digest(value: Any) -> str:
    """Hash of a value that `canonical` can write, 64 hexadecimal digits."""
    return hashlib.sha256(canonical(value).encode()).hexdigest()


def seed_of(*parts: Any) -> int:
    """A seed in [0, 2**31) from the identity of what it is for: the same whoever runs it, and when."""
    return int(digest(parts)[:8], 16) >> 1


def digest_files(*paths: Path) -> str:
    """Hash of the names and contents of files."""
    total = hashlib.sha256()
    for path in sorted(paths):
        total.update(path.name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()


@cache
def code_version(module: str) -> str:
    """Hash of a module and of all project modules that it reaches through imports, 16 hexadecimal digits.

    Parameters
    ----------
    module
        Dotted name. Modules outside the project (a user's own method) count with their own source.
    """
    seen: dict[str, str] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in seen:
            continue
        seen[name], imported = _facts(name)
        waiting.extend(sorted(imported - set(seen)))
    return digest(seen)[:16]


@cache
def _facts(module: str) -> tuple[str, frozenset[str]]:
    """Hash of a module's substance, and the project modules that it imports."""
    tree = _parsed(module)
    imported = frozenset(_imported(tree))
    return hashlib.sha256(_substance(tree).encode()).hexdigest(), imported


@cache
def _parsed(module: str) -> ast.Module:
    spec = find_spec(module)
    if spec is None or spec.origin is None or not spec.origin.endswith(".py"):
        raise ModuleNotFoundError(f"no source of module {module!r}")
    return ast.parse(Path(spec.origin).read_text(encoding="utf-8"))


def _substance(tree: ast.Module) -> str:
    """The module without docstrings, comments and layout."""
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and body and ast.get_docstring(node):
            node.body = body[1:]
    return ast.dump(tree)


def _imported(tree: ast.Module) -> Iterator[str]:
    """Project modules that a module imports, at its top or inside functions."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if _ours(alias.name))
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0 and _ours(node.module):
            for alias in node.names:
                yield _home(node.module, alias.name)


def _ours(module: str) -> bool:
    return module.split(".")[0] in PROJECT


@cache
def _home(module: str, name: str) -> str:
    """The module that defines a name imported from a module or package."""
    if find_spec(f"{module}.{name}") is not None if _is_package(module) else False:
        return f"{module}.{name}"
    if _is_package(module):
        for node in ast.walk(_parsed(module)):
            if isinstance(node, ast.ImportFrom) and node.module and _ours(node.module):
                for alias in node.names:
                    if (alias.asname or alias.name) == name:
                        return _home(node.module, alias.name)
    return module


@cache
def _is_package(module: str) -> bool:
    spec = find_spec(module)
    return spec is not None and spec.submodule_search_locations is not None


def resolve(reference: str) -> Any:
    """The object named ``"module:attribute"``."""
    module, _, attribute = reference.partition(":")
    return getattr(import_module(module), attribute)

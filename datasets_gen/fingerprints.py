"""Hashes that say whether a stored result may be used again: of values, of files, of code and libraries.

A result may be used again only if nothing that made it has changed: its settings, its inputs, the source of
every project module that its code reaches through imports, and the versions of the libraries that these
modules import. Comments, docstrings and layout do not count. A change in a metric changes the keys of
scores, not those of scans.
"""

import ast
import hashlib
import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

PROJECT = ("datasets_gen", "scanner_sim", "medial", "evaluation", "reports")

DISTRIBUTIONS = {"skimage": "scikit-image", "PIL": "pillow"}
"""Names on the package index of libraries that are imported under another name."""

NO_RESULTS = frozenset({"OpenEXR", "PIL", "click", "filelock", "rich", "threadpoolctl", "tomli_w"})
"""Libraries that write files or messages, or set threads: no result depends on their versions."""


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


def digest_files(*paths: Path, root: Path | None = None) -> str:
    """Hash of the names and contents of files; of their paths within `root`, where it is given."""
    total = hashlib.sha256()
    for path in sorted(paths):
        name = path.name if root is None else path.relative_to(root).as_posix()
        total.update(
            name.encode("utf-8", "surrogatepass") + b"\0" + hashlib.sha256(path.read_bytes()).digest()
        )
    return total.hexdigest()


def code_fingerprint(*modules: str) -> str:
    """Hash of modules, of all project modules that they reach through imports, and of library versions.

    Parameters
    ----------
    *modules
        Dotted names, or paths of Python files (a user's own method).

    Returns
    -------
    str
        16 hexadecimal digits.

    Raises
    ------
    ModuleNotFoundError
        If a module has no source.
    """
    return _fingerprint(modules, digest_files(*(Path(name) for name in modules if _is_file(name))))


@cache
def _fingerprint(modules: tuple[str, ...], files: str) -> str:
    """The fingerprint, computed once; `files` changes when a file among the modules was edited."""
    sources = {
        Path(name).name if _is_file(name) else name: _facts(name).substance for name in _reached(modules)
    }
    return digest([sources, library_versions(*modules)])[:16]


def library_versions(*modules: str) -> dict[str, str]:
    """Versions of the libraries that modules, and all project modules that they reach, import.

    Parameters
    ----------
    *modules
        As for `code_fingerprint`.

    Returns
    -------
    dict
        Version by name on the package index, sorted by name. Libraries that are not installed and those
        that decide no result (`NO_RESULTS`) are left out.
    """
    found = {}
    libraries = {library for name in _reached(modules) for library in _facts(name).libraries}
    for library in libraries - NO_RESULTS:
        distribution = DISTRIBUTIONS.get(library, library.replace("_", "-"))
        with suppress(PackageNotFoundError):
            found[distribution] = version(distribution)
    return dict(sorted(found.items()))


def _reached(modules: Iterable[str]) -> list[str]:
    """The modules and all project modules that they import, directly or through others; sorted."""
    seen: set[str] = set()
    waiting = list(modules)
    while waiting:
        name = waiting.pop()
        if name not in seen:
            seen.add(name)
            waiting.extend(_facts(name).imported - seen)
    return sorted(seen)


class _Facts(NamedTuple):
    """Hash of a module's substance, the project modules and the libraries that it imports."""

    substance: str
    imported: frozenset[str]
    libraries: frozenset[str]


def _facts(module: str) -> _Facts:
    """Facts of a module; files are read again, as a session may edit its method between two runs."""
    if _is_file(module):
        return _tree_facts(ast.parse(Path(module).read_text(encoding="utf-8")))
    return _module_facts(module)


@cache
def _module_facts(module: str) -> _Facts:
    return _tree_facts(_parsed(module))


def _tree_facts(tree: ast.Module) -> _Facts:
    imported, libraries = frozenset(_imported(tree)), frozenset(_libraries(tree)) - sys.stdlib_module_names
    return _Facts(hashlib.sha256(_substance(tree).encode()).hexdigest(), imported, libraries)


@cache
def _parsed(module: str) -> ast.Module:
    """Syntax tree of a module's source."""
    spec = find_spec(module)
    if spec is None or spec.origin is None or not spec.origin.endswith(".py"):
        raise ModuleNotFoundError(f"no source of module {module!r}")
    return ast.parse(Path(spec.origin).read_text(encoding="utf-8"))


def _is_file(module: str) -> bool:
    return module.endswith(".py")


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


def _libraries(tree: ast.Module) -> Iterator[str]:
    """Packages outside the project that a module imports; the standard library included."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names if not _ours(alias.name))
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0 and not _ours(node.module):
            yield node.module.split(".")[0]


def _ours(module: str) -> bool:
    return module.split(".")[0] in PROJECT


@cache
def _home(module: str, name: str) -> str:
    """The module that defines a name imported from a module or package."""
    if not _is_package(module):
        return module
    for node in ast.walk(_parsed(module)):  # before submodules: `scanner_sim.scan` is a function and a module
        if isinstance(node, ast.ImportFrom) and node.module and _ours(node.module):
            for alias in node.names:
                if (alias.asname or alias.name) == name:
                    return _home(node.module, alias.name)
    return f"{module}.{name}" if find_spec(f"{module}.{name}") is not None else module


@cache
def _is_package(module: str) -> bool:
    spec = find_spec(module)
    return spec is not None and spec.submodule_search_locations is not None

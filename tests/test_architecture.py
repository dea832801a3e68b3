"""Data flows one way: a package imports only itself and the packages to its left."""

import ast
import tomllib
from pathlib import Path

import pytest

ORDER = ["datasets_gen", "scanner_sim", "medial", "evaluation", "reports"]
ROOT = Path(__file__).resolve().parent.parent


def imported_packages(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            yield node.module.split(".")[0]


@pytest.mark.parametrize("package", ORDER)
def test_imports_point_left(package):
    allowed = set(ORDER[: ORDER.index(package) + 1])
    offenders = [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in sorted((ROOT / package).rglob("*.py"))
        for name in imported_packages(path)
        if name in ORDER and name not in allowed
    ]
    assert not offenders


def test_medial_does_not_know_the_scanner():
    offenders = [
        str(path.relative_to(ROOT))
        for path in sorted((ROOT / "medial").rglob("*.py"))
        if "scanner_sim" in set(imported_packages(path))
    ]
    assert not offenders, "medial works on any oriented cloud"


def test_wheel_contains_every_package():
    """Packages are listed by hand, so a new folder is easily forgotten."""
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    found = [
        ".".join(path.parent.relative_to(ROOT).parts)
        for package in ORDER
        for path in (ROOT / package).rglob("__init__.py")
    ]
    assert sorted(listed) == sorted(found)

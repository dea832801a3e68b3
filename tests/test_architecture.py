"""The house in order: layers, no import cycles, short files, one meaning for a name, a complete wheel."""

import ast
import graphlib
import re
import tomllib
from collections import defaultdict
from functools import cache
from pathlib import Path

import pytest

from datasets_gen.compiled import grown

ORDER = ["datasets_gen", "scanner_sim", "medial", "evaluation", "reports"]
ROOT = Path(__file__).resolve().parent.parent
FACE = "medialbench"
"""The thin module that gathers the public names; it may import every package and none may import it."""
MOST_LINES = 300
EQUATIONS = "equations.py"
"""In each room the same: its equations of the paper, as written."""
COMMANDS = ROOT / "reports" / "cli"
"""Each module here is named like the command that it runs, as the module may be that does the work."""


@cache
def modules():
    """Path of every module by its dotted name."""
    paths = [path for package in ORDER for path in sorted((ROOT / package).rglob("*.py"))]
    paths += [path for path in [ROOT / f"{FACE}.py"] if path.exists()]
    found = {}
    for path in paths:
        parts = path.relative_to(ROOT).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@cache
def imports(module):
    """Project modules that a module imports anywhere: in functions and under TYPE_CHECKING too."""
    path = modules()[module]
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) + 1 - node.level] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            for alias in node.names:  # a submodule, or else a name within the module
                submodule = f"{base}.{alias.name}"
                found.add(submodule if submodule in modules() else base)
    return found & set(modules())


def test_imports_are_read_wherever_they_stand():
    assert "scanner_sim.scan" in imports("scanner_sim")
    assert "scanner_sim.tracing.variant" in imports("scanner_sim.scanner")  # from ... import module
    assert "datasets_gen.collections.folder" in imports("datasets_gen")


@pytest.mark.parametrize("package", ORDER)
def test_imports_point_left(package):
    allowed = set(ORDER[: ORDER.index(package) + 1])
    offenders = [
        f"{module} imports {other}"
        for module in modules()
        if module.split(".")[0] == package
        for other in sorted(imports(module))
        if other.split(".")[0] not in allowed
    ]
    assert not offenders


def test_medial_does_not_know_the_scanner():
    offenders = [
        module
        for module in modules()
        if module.startswith("medial.") and any(m.startswith("scanner_sim") for m in imports(module))
    ]
    assert not offenders, "medial works on any oriented cloud"


def test_kernels_are_compiled_in_one_way():
    """Numba's `fastmath` would give other bits with each compilation (docs/reproducibility.md)."""
    assert [module for module, path in modules().items() if "njit" in path.read_text(encoding="utf-8")] == [
        "datasets_gen.compiled"
    ]
    assert not grown.targetoptions.get("fastmath")


def test_trees_are_asked_on_our_threads():
    """SciPy's own crash the process after Ctrl-C (`datasets_gen.points.neighbours.query_tree`)."""
    asked = re.compile(r"\.query\w*\([^=]*\bworkers=|workers=thread_count")
    assert [m for m, path in modules().items() if asked.search(path.read_text(encoding="utf-8"))] == []


def test_no_import_cycles():
    """Imports within functions and under TYPE_CHECKING count: two modules that need each other are one."""
    try:
        tuple(graphlib.TopologicalSorter({module: imports(module) for module in modules()}).static_order())
    except graphlib.CycleError as error:
        pytest.fail(" <- ".join(error.args[1]))


def test_wheel_contains_every_package():
    """Packages are listed by hand, so a new folder is easily forgotten."""
    setup = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    folders = {path.parent for package in ORDER for path in (ROOT / package).rglob("*.py")}
    assert sorted(setup["packages"]) == sorted(".".join(f.relative_to(ROOT).parts) for f in folders)
    assert not [str(folder) for folder in folders if not (folder / "__init__.py").exists()]
    if FACE in modules():
        assert setup["py-modules"] == [FACE]


def test_every_folder_says_what_lives_there():
    silent = [
        module
        for module, path in modules().items()
        if path.name == "__init__.py" and not ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert not silent


def test_files_are_short():
    lengths = {name: len(path.read_text(encoding="utf-8").splitlines()) for name, path in modules().items()}
    assert not {name: length for name, length in lengths.items() if length > MOST_LINES}


def test_no_two_modules_share_a_name():
    named = defaultdict(list)
    for module, path in modules().items():
        if path.name not in ("__init__.py", EQUATIONS) and path.parent != COMMANDS:
            named[path.stem].append(module)
    assert not {name: found for name, found in named.items() if len(found) > 1}


def test_no_two_classes_share_a_name():
    """Private names may repeat."""
    named = defaultdict(list)
    for module, path in modules().items():
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                named[node.name].append(module)
    assert not {name: found for name, found in named.items() if len(found) > 1}

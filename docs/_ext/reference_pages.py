"""Pages of the reference, one for each package and folder, from the source files.

What is documented is found by reading the files, not by importing them: functions, classes and constants with
a docstring whose names do not begin with an underscore. A name that a package exports (`__all__`) is
documented on the package's page under the name by which users import it, and only there.
"""

import ast
from dataclasses import dataclass, field
from inspect import cleandoc
from pathlib import Path
from textwrap import indent

ROOT = Path(__file__).resolve().parents[2]
FACE = "medialbench"
PACKAGES = ("datasets_gen", "scanner_sim", "medial", "evaluation", "reports")
HANDED = ("Collection", "Shape", "Scan", "Diffusion", "Matching", "MatchConfig", "Departures", "InputError")
"""What the functions of `FACE` take, give and raise."""
SHORT = 60
"""Characters up to which the value of a constant is shown."""


@dataclass(frozen=True)
class SourceFile:
    """A module: its dotted name, its docstring and the entry of each public member."""

    name: str
    docstring: str
    members: dict[str, str]
    exports: dict[str, str] = field(default_factory=dict)
    """Of a package: the module in which each name of `__all__` is defined."""


def source_files() -> dict[str, SourceFile]:
    """All modules by dotted name, packages under the name of their folder."""
    paths = [ROOT / f"{FACE}.py"]
    for package in PACKAGES:
        paths += sorted((ROOT / package).rglob("*.py"))
    found = {}
    for path in paths:
        parts = path.relative_to(ROOT).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        found[name] = _read(name, path)
    return found


def _read(name: str, path: Path) -> SourceFile:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    members = {}
    for node, after in zip(tree.body, [*tree.body[1:], None], strict=True):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            if not node.name.startswith("_") and not _is_command(node):
                members[node.name] = _entry_of(node)
        elif isinstance(node, ast.Assign | ast.AnnAssign) and (text := _text(after)):
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            if isinstance(target, ast.Name) and not target.id.startswith("_"):
                members[target.id] = _constant(target.id, node.value, text)
    wanted = {
        each.value
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
        for each in ast.walk(node.value)
        if isinstance(each, ast.Constant)
    }
    exports = {
        alias.asname or alias.name: str(node.module)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if (alias.asname or alias.name) in wanted
    }
    return SourceFile(name, ast.get_docstring(tree) or "", members, exports)


def _text(node: ast.stmt | None) -> str:
    """The docstring of what stands before it, or nothing."""
    value = node.value if isinstance(node, ast.Expr) else None
    return value.value if isinstance(value, ast.Constant) and isinstance(value.value, str) else ""


def _is_command(node: ast.FunctionDef | ast.ClassDef) -> bool:
    """Whether the command line calls it: the page of the command line has it."""
    return any(ast.unparse(each).startswith("click.") for each in node.decorator_list)


def _entry_of(node: ast.FunctionDef | ast.ClassDef) -> str:
    if isinstance(node, ast.ClassDef):
        return f".. autoclass:: {node.name}\n   :members:\n"
    return f".. autofunction:: {node.name}\n"


def _constant(name: str, value: ast.expr | None, text: str) -> str:
    """An entry with the value as it is written, where it is short; aliases of types are constants."""
    written = ast.unparse(value) if value is not None else ""
    shown = f"   :value: {written}\n" if 0 < len(written) <= SHORT else ""
    return f".. py:data:: {name}\n{shown}\n{indent(cleandoc(text), '   ')}\n"


def public_names(files: dict[str, SourceFile]) -> dict[str, str]:
    """Name by which users import each exported object, by the name of the place where it is defined."""
    return {
        f"{home}.{name}": f"{package}.{name}"
        for package, each in files.items()
        for name, home in each.exports.items()
        if package != FACE
    }


def pages() -> dict[str, str]:
    """Text of every page, by the name of its package or folder."""
    files = source_files()
    public = public_names(files)
    folders = [name for name in files if name in PACKAGES or any(n.startswith(f"{name}.") for n in files)]
    return {FACE: _face(files)} | {name: _page(name, files, public) for name in folders}


def _face(files: dict[str, SourceFile]) -> str:
    members = files[FACE].members.items()
    own = "\n".join(
        [entry for _, entry in members if entry.startswith(".. autofunction")]
        + [f".. autofunction:: {name}\n" for name in files[FACE].exports if name not in HANDED]
    )
    links = ", ".join(f"`{each}`" for each in HANDED)
    return (
        f"{_title(FACE, '=')}\n.. automodule:: {FACE}\n\n{own}\n\n{_title('Classes', '-')}\n"
        f"What these functions take and return is documented with the packages: {links}.\n"
    )


def _page(package: str, files: dict[str, SourceFile], public: dict[str, str]) -> str:
    text = [_title(package, "=") + _module(package, public)]
    for name, home in files[package].exports.items():
        text.append(files[home].members.get(name, f".. autodata:: {name}\n   :no-value:\n"))
    within = [name for name in files if name.rpartition(".")[0] == package]
    folders = [name for name in within if any(other.startswith(f"{name}.") for other in files)]
    if package in PACKAGES and len(within) > len(folders):
        text.append(".. rubric:: Modules\n\nFurther names, by the module that defines them.\n")
    for name in sorted(set(within) - set(folders), key=lambda each: _mention(each, files[package].docstring)):
        text.append(_title(name.rpartition(".")[2], "-") + _module(name, public))
        moved = [member for member in files[name].members if f"{name}.{member}" in public]
        text += [entry for member, entry in files[name].members.items() if member not in moved]
        if moved:
            links = ", ".join(f":py:obj:`{public[f'{name}.{member}']}`" for member in moved)
            text.append(f"Defined here, documented with its package: {links}.\n")
    if files[package].members:
        text += [f".. py:currentmodule:: {package}\n", *files[package].members.values()]
    if folders:
        listed = "\n".join(
            f"   {each.rpartition('.')[2]} <{each}>"
            for each in sorted(folders, key=lambda each: _mention(each, files[package].docstring))
        )
        text.append(f".. rubric:: Folders\n\n.. toctree::\n\n{listed}\n")
    return "\n".join(text)


def _mention(name: str, docstring: str) -> tuple[int, str]:
    """Where a package first speaks of a module: the order in which it is to be read."""
    stem = name.rpartition(".")[2]
    return next((at for mark in (f"`{stem}`", f"`{stem}.") if (at := docstring.find(mark)) >= 0), 10**6), stem


def _module(name: str, public: dict[str, str]) -> str:
    """The docstring of a module; one named like an exported function cannot be linked to."""
    hidden = "   :no-index:\n" if name in public.values() else ""
    return f"\n.. automodule:: {name}\n{hidden}"


def _title(text: str, line: str) -> str:
    return f"{text}\n{line * len(text)}\n"


def write_pages(folder: Path) -> None:
    """Write the pages that have changed, and remove those of folders that are gone."""
    folder.mkdir(exist_ok=True)
    wanted = {folder / f"{name}.rst": text for name, text in pages().items()}
    for path in set(folder.glob("*.rst")) - set(wanted):
        path.unlink()
    for path, text in wanted.items():
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")

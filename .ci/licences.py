"""Write docs/licences.md: licences of all packages that an installation brings along, by their own metadata.

``.venv/bin/python .ci/licences.py``, in an environment with all extras.
"""

import tomllib
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parent.parent
HEAD = """# Licences of what is installed

medialbench itself has the MIT licence. `pip install medialbench` brings the packages marked *always*; the
others come with an extra (`pip install 'medialbench[peers]'`), directly or through another package.
Licences are what the packages' own metadata say. This page is made by `.venv/bin/python .ci/licences.py`,
on Linux with Python 3.11 and all extras installed.

| package | version | licence | comes with | web page |
|---|---|---|---|---|
"""


FROM_FILES = {"openexr": "BSD-3-Clause", "atheris": "Apache-2.0", "anny": "Apache-2.0 AND CC0-1.0"}
"""Licences of packages whose metadata say nothing, from the licence files that they install."""


def main() -> None:
    """Write the page."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    groups = {"always": project["dependencies"], **project["optional-dependencies"]}
    del groups["all"]  # the packages of other extras
    needed: dict[str, tuple[Distribution | None, str, list[str]]] = {}
    for group, requirements in groups.items():
        for name, found in _closure(requirements).items():
            key = name.lower().replace("_", "-")
            needed.setdefault(key, (found, name, []))[2].append(group)
    lines = [
        f"| {name} | {found.version if found else 'not installed'} | {_licence(found)} "
        f"| {'always' if 'always' in groups else ', '.join(groups)} | {_page(found)} |"
        for _, (found, name, groups) in sorted(needed.items())
    ]
    (ROOT / "docs" / "licences.md").write_text(HEAD + "\n".join(lines) + "\n", encoding="utf-8")


def _closure(requirements: list[str]) -> dict[str, Distribution | None]:
    """The packages that are asked for and all that they need here."""
    found: dict[str, Distribution | None] = {}
    waiting = [(Requirement(each), frozenset({""})) for each in requirements]
    seen = set()
    while waiting:
        wanted, extras = waiting.pop()
        marker = wanted.marker
        if marker and not any(marker.evaluate({"extra": extra}) for extra in extras):
            continue
        key = (wanted.name.lower().replace("_", "-"), frozenset(wanted.extras))
        if key in seen:
            continue
        seen.add(key)
        try:
            found[key[0]] = distribution(wanted.name)
        except PackageNotFoundError:
            found[key[0]] = None
            continue
        inner = [Requirement(each) for each in distribution(wanted.name).requires or []]
        waiting += [(each, frozenset({"", *wanted.extras})) for each in inner]
    return found


def _licence(found: Distribution | None) -> str:
    """The licence expression, else the classifiers, else the first line of a text."""
    if found is None:
        return "unknown"
    named = [
        each.rpartition(" :: ")[2] for each in _fields(found, "Classifier") if each.startswith("License")
    ]
    exact = ", ".join(name for name in named if name != "OSI Approved")
    text = next(iter(_fields(found, "License")), "").strip().split("\n")[0]
    expression = next(iter(_fields(found, "License-Expression")), "")
    return expression or exact or text or FROM_FILES.get(found.metadata["Name"].lower(), "unknown")


def _fields(found: Distribution, name: str) -> list[str]:
    """Values of an entry of the metadata."""
    return list(found.metadata.get_all(name) or [])


def _page(found: Distribution | None) -> str:
    """Home page, repository or documentation; else its page on the package index."""
    if found is None:
        return ""
    pairs = [each.split(",", 1) for each in _fields(found, "Project-URL")]
    words = {name.strip().lower(): link.strip() for name, link in pairs}
    for name in ("homepage", "repository", "source", "source code", "github", "documentation"):
        if name in words:
            return words[name]
    return next(iter(_fields(found, "Home-page")), f"https://pypi.org/project/{found.metadata['Name']}/")


if __name__ == "__main__":
    main()

"""What is shipped: data files, types, versions, licences."""

import re
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest

from tests.test_architecture import ORDER

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
SHIPPED = PROJECT["tool"]["setuptools"]["package-data"]


def data_files():
    """Files of the packages that are no code, by package, as the wheel has to hold them."""
    for package in ORDER:
        for path in (ROOT / package).rglob("*"):
            if path.is_file() and path.suffix != ".py" and "__pycache__" not in path.parts:
                yield ".".join(path.parent.relative_to(ROOT).parts), path.name


def test_every_data_file_is_shipped():
    found = list(data_files())
    assert ("evaluation.protocols", "quick.toml") in found
    assert ("reports.page", "report.html.j2") in found
    lost = [
        (package, name)
        for package, name in found
        if not any(fnmatch(name, pattern) for pattern in SHIPPED.get(package, []))
    ]
    assert lost == []


def test_every_pattern_of_data_files_finds_some():
    found = list(data_files())
    idle = [
        (package, pattern)
        for package, patterns in SHIPPED.items()
        for pattern in patterns
        if not any(package == home and fnmatch(name, pattern) for home, name in found)
    ]
    assert idle == []


@pytest.mark.parametrize("package", ORDER)
def test_packages_say_that_they_are_typed(package):
    assert (ROOT / package / "py.typed").is_file()


def test_the_version_is_the_same_everywhere():
    version = PROJECT["project"]["version"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {version}\n" in citation
    assert f"\n## {version} (" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_citation_and_licence_agree():
    assert f"\nlicense: {PROJECT['project']['license']}\n" in (ROOT / "CITATION.cff").read_text(
        encoding="utf-8"
    )
    assert (ROOT / "LICENSE").read_text(encoding="utf-8").startswith(PROJECT["project"]["license"])


EXTRAS = PROJECT["project"]["optional-dependencies"]


def names_of(requirements):
    """Packages that requirements name, those of extras of the project itself in their place."""
    found = set()
    for each in requirements:
        name, extras = re.match(r"([\w-]+)(?:\[([\w,]+)\])?", each).groups()
        if name == PROJECT["project"]["name"]:
            found |= names_of([each for extra in extras.split(",") for each in EXTRAS[extra]])
        else:
            found.add(name.lower())
    return found


def test_the_extra_all_is_what_users_may_want():
    """Every extra but bodies that bring torch or MuJoCo, and the tools of those who work on the code."""
    others = [
        each
        for name, extra in EXTRAS.items()
        if name not in ("all", "anny", "animals", "dev", "docs", "fuzz", "mutation")
        for each in extra
    ]
    assert names_of(EXTRAS["all"]) == names_of(others)


def test_every_dependency_has_its_licence_listed():
    wanted = [*PROJECT["project"]["dependencies"], *(each for extra in EXTRAS.values() for each in extra)]
    names = names_of(wanted)
    page = (ROOT / "docs" / "licences.md").read_text(encoding="utf-8")
    listed = {line.split("|")[1].strip().lower() for line in page.splitlines() if line.startswith("| ")}
    assert names - listed == set()


def test_pages_that_are_linked_are_there():
    for page in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"):
        for link in re.findall(r"\]\(([^)#:]+)\)", (ROOT / page).read_text(encoding="utf-8")):
            assert (ROOT / link).exists(), f"{page}: {link}"

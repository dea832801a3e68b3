"""The pages in docs/: links go somewhere, every public module has its place, what is shown to be run runs."""

import importlib.util
import re
import sys
import tomllib
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
import trimesh

from datasets_gen import load
from evaluation import Experiment, ResultsStore
from evaluation import run as run_experiment
from evaluation.experiment.config_sections import (
    DatasetSection,
    MatchingSection,
    MethodSection,
    OperatorsSection,
    ScanCondition,
    StabilitySection,
)
from reports.cli.main import COMMANDS
from tests.test_architecture import ORDER, modules

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted((ROOT / "docs").glob("*.md"))
AT_ROOT = [ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")]


def prose(path):
    """A page without its blocks of code."""
    return re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def anchors(path):
    """Anchors of the headings, as GitHub and MyST make them."""
    heads = re.findall(r"^#+ (.+)$", prose(path), flags=re.MULTILINE)
    return {re.sub(r"[^\w -]", "", head.strip().lower()).replace(" ", "-") for head in heads}


def links(path):
    return re.findall(r"\]\((?!\w+:)([^)\s]*)\)", prose(path))


def test_links_are_seen():
    assert "methods.md#points-without-a-match" in links(ROOT / "docs" / "evaluation.md")
    assert "points-without-a-match" in anchors(ROOT / "docs" / "methods.md")


@pytest.mark.parametrize("page", [*PAGES, *AT_ROOT], ids=lambda path: path.name)
def test_links_within_the_project_resolve(page):
    broken = []
    for link in links(page):
        name, _, anchor = link.partition("#")
        goal = page.parent / name if name else page
        if not goal.exists() or (anchor and anchor not in anchors(goal)):
            broken.append(link)
    assert not broken


def contents():
    """Pages that the table of contents lists."""
    trees = re.findall(r"```\{toctree\}\n(.*?)```", (ROOT / "docs/index.md").read_text(), flags=re.DOTALL)
    lines = [line for tree in trees for line in tree.splitlines() if line and not line.startswith(":")]
    return [re.sub(r"^.* <(.*)>$", r"\1", line) for line in lines]


def test_every_page_is_in_the_table_of_contents():
    listed = contents()
    assert len(listed) == len(set(listed))
    assert {page.stem for page in PAGES} - {"index"} <= set(listed)
    assert not set(listed) - {page.stem for page in PAGES}


def test_every_page_can_be_reached_from_the_readme():
    """By links, as on GitHub; but for those that Sphinx alone can show."""
    reached, waiting = set(), [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        if page in reached or page.suffix != ".md" or not page.exists():
            continue
        reached.add(page)
        waiting += [(page.parent / link.partition("#")[0]).resolve() for link in links(page)]
    shown_by_sphinx = {"index", "cli", "reference", "changelog", "contributing"}
    wanted = {page.stem for page in PAGES} - shown_by_sphinx
    assert not wanted - {page.stem for page in reached}


@pytest.fixture(scope="module")
def reference():
    """Generated pages of the reference, by name."""
    spec = importlib.util.spec_from_file_location("reference_pages", ROOT / "docs/_ext/reference_pages.py")
    found = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = found  # dataclasses look there for the module
    spec.loader.exec_module(found)
    yield found.pages()
    del sys.modules[spec.name]


def test_every_module_is_in_the_reference(reference):
    described = re.findall(r"^\.\. automodule:: (\S+)$", "\n".join(reference.values()), flags=re.MULTILINE)
    assert sorted(described) == sorted(modules())


def test_every_package_is_linked_from_the_reference(reference):
    page = (ROOT / "docs/reference.md").read_text(encoding="utf-8")
    linked = set(re.findall(r"^api/(\S+)$", page, flags=re.MULTILINE))
    for text in reference.values():
        linked |= set(re.findall(r"^   \w+ <([\w.]+)>$", text, flags=re.MULTILINE))
    assert linked == set(reference)
    assert set(ORDER) <= linked


@pytest.mark.parametrize("package", [*ORDER, "medialbench"])
def test_exported_names_are_documented_on_the_page_of_their_package(reference, package):
    exported = {name for name in importlib.import_module(package).__all__ if not name.startswith("_")}
    entries = set(re.findall(r"^\.\. [\w:]+:: (\w+)$", reference[package], flags=re.MULTILINE))
    linked = set(re.findall(r"`(\w+)`", reference[package]))
    assert not exported - entries - linked
    if package != "medialbench":  # classes of other packages are linked there
        assert exported <= entries


def test_the_command_line_is_made_from_its_commands():
    page = (ROOT / "docs/cli.md").read_text(encoding="utf-8")
    assert ".. click:: reports.cli.main:cli" in page
    assert ":nested: full" in page
    assert len(COMMANDS) > 5


def blocks(page, language):
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)


def run(block):
    names = {"__name__": "page"}
    exec(compile(block, "page", "exec"), names)
    return names


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_key_of_an_experiment_is_explained():
    text = (ROOT / "docs" / "evaluation.md").read_text(encoding="utf-8")
    cells = [line.split("|")[1] for line in text.splitlines() if line.startswith("|")]
    named = set(re.findall(r"`\[*([a-z_]+)\]*`", " ".join(cells)))
    sections = (
        DatasetSection,
        ScanCondition,
        OperatorsSection,
        StabilitySection,
        MatchingSection,
        MethodSection,
    )
    known = {field.name: field.default for section in (Experiment, *sections) for field in fields(section)}
    assert set(known) <= named, set(known) - named
    rows = [
        [cell.strip() for cell in line.split("|")[1:3]] for line in text.splitlines() if line.count("|") > 3
    ]
    said = {re.findall(r"`([a-z_]+)`", key)[-1]: default for key, default in rows if "`" in key}
    for name in ("timeout", "evaluated", "departures", "threshold", "views", "points", "modes", "poses"):
        assert tomllib.loads(f"x = {said[name]}")["x"] == known[name], name


def test_your_own_data_is_a_data_set(folder):
    """The folder that the page makes is loaded, and its experiment can be read."""
    run(blocks("your-own-data.md", "python")[0])
    (folder / "star.toml").write_text(blocks("your-own-data.md", "toml")[0])
    settings = Experiment.load("star.toml")
    assert [method.name for method in settings.method] == ["medial", "heat"]
    section = settings.dataset[0]
    body = load(section.name, poses=section.poses, **section.options)
    assert body.poses == ("rest", "bent")
    assert all(trimesh.Trimesh(each.vertices, each.faces, process=False).is_watertight for each in body)
    assert not np.allclose(body["bent"].vertices, body["rest"].vertices)


@pytest.mark.long
@pytest.mark.slow
def test_your_own_data_runs_from_top_to_bottom(folder):
    write, measure, clouds = blocks("your-own-data.md", "python")
    run(write)
    found = run(measure)
    assert found["a"].points.shape == (500, 3)
    error = found["mb"].geodesic_error(found["found"], found["a"], found["b"], found["body"])
    assert error.shape == (500,)
    for name, scan in (("a.xyz", found["a"]), ("b.xyz", found["b"])):
        np.savetxt(folder / name, np.column_stack([scan.points, scan.normals])[::2])
    assert len(run(clouds)["found"].source_to_target) == 250


def test_your_own_method_runs_on_one_pair(folder):
    write, attempt, *_ = blocks("your-own-method.md", "python")
    (folder / "mine.py").write_text(write)
    found = run(attempt)
    error = found["mb"].geodesic_error(
        found["found"], found["clouds"][0].scan, found["clouds"][1].scan, found["body"]
    )
    at_random = np.random.default_rng(0).permutation(2000)
    guessed = found["mb"].geodesic_error(
        run(write)["dense"](at_random, np.ones(2000)),
        found["clouds"][0].scan,
        found["clouds"][1].scan,
        found["body"],
    )
    assert error.mean() < 0.7 * guessed.mean()


@pytest.mark.long
@pytest.mark.slow
def test_your_own_method_competes(folder):
    """The experiment of the page, smaller; and the export of its clouds for a method that runs elsewhere."""
    (folder / "mine.py").write_text(blocks("your-own-method.md", "python")[0])
    text = next(each for each in blocks("your-own-method.md", "toml") if each.startswith("# mine.toml"))
    scan = "[scan]\npoints = 400\nviews = 3\nscanner = { resolution = [100, 100] }\n"
    small = f"{scan}\n[operators]\nmodes = 40\n\n[matching]"
    text = text.replace("poses = 3", "poses = 2").replace("[matching]", small).replace("[0.3, 0.8]", "[0.3]")
    (folder / "mine.toml").write_text(text)
    run_experiment("mine.toml", "results/matching", jobs=1)
    table = ResultsStore("results/matching").table()
    assert sorted(table["method"]) == ["medial", "signatures"]
    run(blocks("your-own-method.md", "python")[2])
    assert len(list((folder / "for_dpfm" / "clouds").glob("*.xyz"))) == 2

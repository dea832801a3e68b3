"""What the pages in docs/ show works."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from evaluation import Experiment, presets
from evaluation.methods import METHODS, MethodInput, create, find
from medial import Diffusion
from scanner_sim import sample
from tests.evaluation.meshes import blob

PAGES = Path(__file__).resolve().parents[2] / "docs"
METHODS_PAGE = (PAGES / "methods.md").read_text(encoding="utf-8")
OWN_PAGE = (PAGES / "your-own-method.md").read_text(encoding="utf-8")
DATA_PAGE = (PAGES / "your-own-data.md").read_text(encoding="utf-8")
EVALUATION_PAGE = (PAGES / "evaluation.md").read_text(encoding="utf-8")
CLUSTER_PAGE = (PAGES / "cluster.md").read_text(encoding="utf-8")


def blocks(page, language):
    return re.findall(rf"```{language}\n(.*?)```", page, flags=re.DOTALL)


@pytest.fixture
def written(tmp_path, monkeypatch):
    """A folder with the page's own method and experiment, as a reader would have it."""
    (tmp_path / "mine.py").write_text(blocks(OWN_PAGE, "python")[0])
    experiment = next(block for block in blocks(OWN_PAGE, "toml") if block.startswith("# mine.toml"))
    (tmp_path / "mine.toml").write_text(experiment)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_method_on_the_page_matches(written):
    method = create("mine.py:Signatures", {"times": 8})
    clouds = []
    for seed in (1, 2):
        scan = sample(blob(4), 300, seed)
        clouds.append(
            MethodInput(
                str(seed), scan, {"robust": Diffusion.from_points(scan.points, scan.normals, "robust", 40)}
            )
        )
    found = method.match(*clouds, seed=0)
    error = np.linalg.norm(clouds[0].points - clouds[1].points[found.source_to_target], axis=1)
    assert len(found) == 300
    assert np.median(error) < 0.5 * np.median(np.linalg.norm(clouds[0].points - clouds[1].points, axis=1))


def test_the_experiment_on_the_page_can_be_read(written):
    experiment = Experiment.load("mine.toml")
    names = [method.name for method in experiment.method]
    assert [Path(name).name for name in names] == ["mine.py:Signatures", "medial"]


@pytest.mark.parametrize("block", blocks(METHODS_PAGE + OWN_PAGE + DATA_PAGE + EVALUATION_PAGE, "toml"))
def test_every_block_of_toml_can_be_read(block):
    assert tomllib.loads(block)


@pytest.mark.parametrize("block", blocks(OWN_PAGE + DATA_PAGE + EVALUATION_PAGE + CLUSTER_PAGE, "python"))
def test_every_block_of_python_compiles(block):
    compile(block, "page", "exec")


def test_the_table_lists_every_method_and_option():
    rows = re.findall(r"^\| `([\w-]+)` \|.*?\|(.*?)\|", METHODS_PAGE, flags=re.MULTILINE)
    assert sorted(name for name, _ in rows) == sorted(METHODS)
    from dataclasses import fields

    for name, options in rows:
        known = {field.name for field in fields(find(name))}
        assert set(re.findall(r"`(\w+)`", options)) <= known


def test_every_preset_is_mentioned():
    assert all(f"`{name}`" in EVALUATION_PAGE for name in presets())

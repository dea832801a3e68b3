"""docs/training-data.md: what is shown to be run runs."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from evaluation.generation import GenerationConfig, read_shards
from evaluation.generation.generation_plan import make_generation_plan
from evaluation.generation.sample_plan import SamplePlan, outlines
from evaluation.generation.shard_task import make_file

PAGE = Path(__file__).resolve().parents[3] / "docs" / "training-data.md"


def blocks(language):
    return re.findall(
        rf"^```{language}\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )


def block(start):
    return next(each for each in blocks("python") if each.startswith(start))


def run(text, **names):
    exec(compile(text, "page", "exec"), names)
    return names


@pytest.fixture
def folder(tiny, blobs, tmp_path, monkeypatch):
    """The folder of the page, of the small body; made here, without workers."""
    shutil.copytree(blobs, tmp_path / "human")
    config = tiny(dataset=[{"name": str(tmp_path / "human")}])
    place = tmp_path / "training" / "quick"
    for task in make_generation_plan(config, 12, 3).tasks:
        assert make_file(str(place), task, "run", 600.0).ok
    monkeypatch.chdir(tmp_path)
    return place


def test_the_loop_reads_every_sample_once(folder):
    samples = run(block("# samples.py"))["samples"]
    found = list(samples("training/quick", held=4))
    kept = {each.key: each for each in read_shards(folder)}
    assert sorted(each["key"] for each in found) == sorted(kept)
    assert [each["key"] for each in found] != sorted(kept)  # shuffled
    for each in found:
        np.testing.assert_array_equal(each["points"], kept[each["key"]].points)
        np.testing.assert_array_equal(each["canonical"], kept[each["key"]].canonical)
        assert each["json"]["dataset"] == "human"
    parts = [each["key"] for part in range(3) for each in samples("training/quick", part=part, parts=3)]
    assert sorted(parts) == sorted(kept)


def test_partners_are_at_the_same_place(folder):
    names = run(block("from evaluation.generation") + block("import numpy as np\nfrom scipy"))
    nearest, is_there = names["target_ids"], names["is_there"]
    assert is_there.any()
    gap = np.linalg.norm(names["other"].canonical[nearest] - names["one"].canonical, axis=1)
    assert gap[is_there].max() <= 2 * names["spacing"]


def test_the_configuration_can_be_used(tmp_path):
    (tmp_path / "mine.toml").write_text(next(each for each in blocks("toml") if "mine.toml" in each))
    config = GenerationConfig.load(tmp_path / "mine.toml")
    plan = SamplePlan(config, outlines(config))
    assert [len(each.individuals) for each in plan.sets] == [20 * 12, 5]
    assert plan.counts(100) == {"train": 90, "val": 10}


def test_the_loop_is_about_twenty_lines_and_compiles():
    text = block("# train.py")
    compile(text, "train.py", "exec")
    assert len([line for line in text.splitlines() if line.strip()]) < 35


def test_the_loop_trains(folder, tmp_path, monkeypatch, capsys):
    pytest.importorskip("torch")
    (tmp_path / "samples.py").write_text(block("# samples.py"))
    monkeypatch.syspath_prepend(tmp_path)
    run(block("# train.py"), __name__="train")
    errors = [float(each) for each in re.findall(r"error ([\d.]+) m", capsys.readouterr().out)]
    assert len(errors) == 5
    assert errors[-1] < errors[0]

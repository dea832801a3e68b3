"""Folders of training data: same bytes for any workers; what is made again, refused and said."""

import csv
import errno
import hashlib
import json
import os
import shutil
from collections import namedtuple

import numpy as np
import pytest
import trimesh

from datasets_gen import InputError
from datasets_gen.shape import Shape
from evaluation.generation import GenerationConfig, generate, read_shards, shard_task
from evaluation.generation.generate import preview_generation
from evaluation.generation.generation_plan import make_generation_plan
from evaluation.generation.shard_task import make_file

SHARDS = ["train-000000.tar", "train-000001.tar", "train-000002.tar"]


def tars(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*.tar"))}


@pytest.fixture
def make(tiny, tmp_path, scheduler):
    """Makes seven samples in shards of three; keyword arguments replace sections and options."""

    def run(folder="data", samples=7, shard_size=3, force=False, **changes):
        options = {"shard_size": shard_size, "force": force, "scheduler": scheduler}
        return generate(tiny(**changes), tmp_path / folder, samples, **options)

    return run


def test_what_is_made_is_complete_and_described(make, blobs, tmp_path):
    result = make()
    assert (result.samples, result.planned, result.made, result.failures) == (7, 7, 7, ())
    folder = tmp_path / "data"
    samples = list(read_shards(folder))
    assert [each.key for each in samples] == [f"train-{index:08d}" for index in range(7)]
    facts = json.loads((folder / "dataset.json").read_text())
    assert facts["complete"]
    assert (facts["samples"], facts["seed"]) == ({"train": 7, "val": 0}, 0)
    assert [each["file"] for each in facts["shards"]] == SHARDS
    assert [each["samples"] for each in facts["shards"]] == [3, 3, 1]  # not divisible
    for each in facts["shards"]:
        content = (folder / each["file"]).read_bytes()
        assert (hashlib.sha256(content).hexdigest(), len(content)) == (each["sha256"], each["bytes"])
    about = facts["datasets"]["blob"]
    missing = [each.about["missing"] for each in samples]
    assert about["statistics"]["missing"]["mean"] == pytest.approx(np.mean(missing), abs=1e-5)
    assert about["statistics"]["missing"]["max"] == pytest.approx(max(missing), abs=1e-5)
    assert sum(about["statistics"]["poses"].values()) == 7
    assert "not stated" in about["licence"]
    assert {"python", "medialbench", "numpy", "mitsuba"} <= set(facts["versions"])
    rest = trimesh.load(blobs / "rest.ply", process=False)
    reference = Shape.load(folder / about["reference"]["file"])
    np.testing.assert_array_equal(reference.faces, rest.faces)
    np.testing.assert_allclose(reference.vertices, rest.vertices, atol=1e-6)
    with (folder / "samples.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [row["key"] for row in rows] == [each.key for each in samples]
    assert [row["shard"] for row in rows] == [SHARDS[0]] * 3 + [SHARDS[1]] * 3 + [SHARDS[2]]
    page = (folder / "DATASHEET.md").read_text()
    assert "7 simulated laser scans" in page
    assert "Not complete" not in page
    assert GenerationConfig.load(folder / "generation.toml").draw.threshold == (0.2, 0.7)


@pytest.mark.slow
def test_two_local_workers_make_the_same_bytes(make, tiny, tmp_path):
    make()
    generate(tiny(), tmp_path / "two", 7, shard_size=3, jobs=2)
    assert tars(tmp_path / "two") == tars(tmp_path / "data")


def test_a_larger_set_begins_with_the_smaller_one(make, tmp_path):
    make(samples=4)
    first = tars(tmp_path / "data")
    assert sorted(first) == SHARDS[:2]
    assert make(samples=7).made == 4  # the second shard had one sample of three
    assert tars(tmp_path / "data")[SHARDS[0]] == first[SHARDS[0]]
    make("fresh")
    assert tars(tmp_path / "data") == tars(tmp_path / "fresh")


def test_other_shards_hold_the_same_samples(make, tmp_path):
    make()
    make("large", shard_size=5)
    one, other = (list(read_shards(tmp_path / name)) for name in ("data", "large"))
    assert [each.members() for each in one] == [each.members() for each in other]


@pytest.mark.parametrize("harm", ["flip", "cut", "remove", "note", "leftover"])
def test_only_what_is_damaged_is_made_again(make, tmp_path, harm, caplog):
    make()
    whole, folder = tars(tmp_path / "data"), tmp_path / "data"
    path = folder / SHARDS[1]
    untouched = (folder / SHARDS[0]).stat().st_mtime_ns
    if harm == "flip":
        content = bytearray(whole[SHARDS[1]])
        content[len(content) // 2] ^= 4
        path.write_bytes(content)
    elif harm == "cut":
        path.write_bytes(whole[SHARDS[1]][:2000])
    elif harm == "remove":
        path.unlink()
    elif harm == "note":
        (folder / "notes" / "train-000001-shard.json").write_text("{")
    else:
        (folder / ".train-000001-abcd1234.tar").write_bytes(b"half")
    assert make().made == (0 if harm == "leftover" else 3)
    assert tars(folder) == whole
    assert (folder / SHARDS[0]).stat().st_mtime_ns == untouched
    assert ("damaged" in caplog.text) == (harm in ("flip", "cut", "remove"))
    assert not list(folder.glob(".train*"))


def test_nothing_is_made_twice(make, tmp_path):
    make()
    times = {path: path.stat().st_mtime_ns for path in (tmp_path / "data").glob("*.tar")}
    assert make().made == 0
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "data").glob("*.tar")} == times


def test_other_settings_are_refused_unless_forced(make, tmp_path):
    make()
    before = tars(tmp_path / "data")
    for changes, words in (
        ({"seed": 1}, "seed was 0, is 1"),
        ({"draw": {"threshold": [0.2, 0.8], "per_render": 2}}, r"draw.threshold\[1\] was 0.7, is 0.8"),
        ({"shard_size": 2}, "shards of 3 samples, not 2"),
        ({"samples": 3}, "more samples than are asked for"),
    ):
        with pytest.raises(InputError, match=words) as caught:
            make(**changes)
        assert "--force" in str(caught.value)
        assert "\n" not in str(caught.value)
    assert tars(tmp_path / "data") == before
    make(samples=3, seed=1, force=True)
    assert sorted(tars(tmp_path / "data")) == SHARDS[:1]
    assert tars(tmp_path / "data")[SHARDS[0]] != before[SHARDS[0]]


def test_names_and_time_limits_decide_no_sample(make):
    make()
    assert make(name="other", description="the same", timeout=99.0).made == 0


def test_meshes_that_have_changed_are_refused(tiny, blobs, tmp_path):
    shutil.copytree(blobs, tmp_path / "blob")
    config = tiny(dataset=[{"name": str(tmp_path / "blob")}])
    before = make_generation_plan(config, 7, 3).state
    mesh = trimesh.load(tmp_path / "blob" / "bent.ply", process=False)
    mesh.apply_scale(1.01)
    mesh.export(tmp_path / "blob" / "bent.ply")
    after = make_generation_plan(config, 7, 3).state
    assert before["settings"] == after["settings"]
    assert before["samples"] != after["samples"]
    shutil.copytree(blobs, tmp_path / "elsewhere" / "blob")
    moved = tiny(dataset=[{"name": str(tmp_path / "elsewhere" / "blob")}])
    assert make_generation_plan(moved, 7, 3).state["samples"] == before["samples"]


def test_shards_of_others_are_never_overwritten(make, tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / SHARDS[0]).write_bytes(b"mine")
    for force in (False, True):
        with pytest.raises(InputError, match="did not make; use another folder"):
            make(force=force)
    assert (tmp_path / "data" / SHARDS[0]).read_bytes() == b"mine"


def test_failing_samples_are_recorded_and_the_rest_goes_on(make, tmp_path):
    dark = {"scanner.exposure": [1.0, 1e-9]}
    changes = {"draw": {"threshold": [0.2, 0.7], "per_render": 2, "sweep": dark}, "samples": 12}
    result = make(**changes)
    assert 0 < result.samples < 12
    assert len(result.failures) == 12 - result.samples
    with (tmp_path / "data" / "failures.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == len(result.failures)
    assert all(row["key"].startswith("train-") and row["dataset"] == "blob" and row["reason"] for row in rows)
    assert len(list(read_shards(tmp_path / "data"))) == result.samples
    assert "**Not complete**" in (tmp_path / "data" / "DATASHEET.md").read_text()
    again = make(**changes)  # they would fail again: nothing is done in vain
    assert (again.made, again.samples, again.failures) == (0, result.samples, result.failures)


def test_a_data_set_that_cannot_be_loaded_takes_no_other_with_it(make, blobs, tmp_path):
    broken = tmp_path / "broken"
    shutil.copytree(blobs, broken)
    (broken / "bent.ply").write_bytes(b"ply\nnothing\n")
    both = [{"name": str(blobs)}, {"name": str(broken)}]
    result = make(dataset=both, samples=8)
    assert result.samples == 4
    assert any(line.startswith("references/broken.npz: ") for line in result.failures)
    with pytest.raises(InputError, match=r"no data set can be loaded.*bent\.ply"):
        make("none", dataset=both[1:])


def test_a_full_disk_is_told_before_anything_is_computed(tiny, tmp_path, monkeypatch):
    plan = make_generation_plan(tiny(), 7, 3)
    usage = namedtuple("usage", "total used free")(10**9, 10**9, 10_000)
    monkeypatch.setattr(shard_task.shutil, "disk_usage", lambda _: usage)
    outcome = make_file(str(tmp_path), plan.shards[0], "run", 600.0)
    assert not outcome.ok
    assert "0 MB are free" in outcome.reason
    assert not list(tmp_path.glob("*.tar"))


def test_a_disk_that_fills_meanwhile_leaves_no_half_shard(tiny, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    plan = make_generation_plan(tiny(), 7, 3)
    monkeypatch.setattr("evaluation.generation.training_sample.tarfile.TarFile.addfile", full)
    outcome = make_file(str(tmp_path), plan.shards[0], "run", 600.0)
    assert not outcome.ok
    assert "free some space" in outcome.reason
    assert not list(tmp_path.rglob("*.tar"))


def test_folders_that_cannot_be_written_are_one_line(make, tmp_path):
    (tmp_path / "data").write_text("a file")
    with pytest.raises(InputError, match="cannot write"):
        make()


def test_previews_write_nothing(make, tiny, tmp_path):
    outlook = preview_generation(tiny(), tmp_path / "data", 7, shard_size=3, jobs=2)
    assert (outlook.stored, outlook.waiting, outlook.workers) == (0, 3, 2)
    assert not (tmp_path / "data").exists()
    make()
    outlook = preview_generation(tiny(), tmp_path / "data", 9, shard_size=3)
    assert (outlook.stored, outlook.waiting) == (2, 1)
    assert outlook.megabytes * 1e6 > sum(map(len, tars(tmp_path / "data").values()))


def test_folders_without_shards_and_damaged_ones_are_one_line(make, tmp_path):
    with pytest.raises(InputError, match="holds no shards"):
        next(read_shards(tmp_path))
    with pytest.raises(InputError, match="split is 'test'"):
        next(read_shards(tmp_path, "test"))
    (tmp_path / "train-000000.tar").write_bytes(b"no tar")
    with pytest.raises(InputError, match="no readable shard"):
        next(read_shards(tmp_path))
    make()
    path = tmp_path / "data" / SHARDS[0]
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(InputError, match=SHARDS[0]):
        list(read_shards(tmp_path / "data"))

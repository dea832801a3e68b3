"""Whatever is damaged in a results folder, the next run makes it again and ends with the same table."""

import json
import logging
import os
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import pytest

from datasets_gen import InputError
from evaluation import ResultsStore, preview, run
from evaluation.results.integrity import SEAL
from evaluation.results.result_files import FOLDERS, RECORD
from evaluation.results.store import MERGED, TIMING

FILES = [f"{FOLDERS[stage]}/*.npz" for stage in FOLDERS if stage != "score"]
RECORDS = [f"{folder}/*.json" for folder in FOLDERS.values()]


class Copied(NamedTuple):
    folder: Path
    table: pd.DataFrame
    again: Callable[[], ResultsStore]
    outlook: Callable[[], Any]


@pytest.fixture(scope="module")
def scheduler():
    """Address of a cluster that all runs share: to start one takes longer than what is made again."""
    from distributed import LocalCluster

    settings = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": "127.0.0.1:0"}
    with LocalCluster(host="127.0.0.1", **settings) as cluster:
        yield cluster.scheduler_address


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory, scheduler):
    """A finished run: its experiment and its folder."""
    made = {}

    def get(small):
        if not made:
            stability = {"operators": ["heat"], "sweep": {"threshold": [0.2]}, "pairs": 200}
            matching = {"pairs": [["rest", "bent"]], "sweep": {"threshold": [0.2]}}
            experiment = small(dataset=[small().dataset[0].__dict__ | {"poses": ["rest", "bent"]}])
            table = experiment.as_dict() | {"stability": stability, "matching": matching}
            experiment = type(experiment).from_table(table)
            store = run(experiment, tmp_path_factory.mktemp("undisturbed") / "results", scheduler=scheduler)
            assert store.failures().empty
            made.update(folder=store.folder, table=store.table().drop(columns=list(TIMING)))
            made["again"] = partial(run, experiment, scheduler=scheduler)
            made["preview"] = partial(preview, experiment)
        return made

    return get


@pytest.fixture
def copied(small, undisturbed, tmp_path):
    """A copy of the results to be damaged, the table, what runs again and what counts what would run."""
    made = undisturbed(small)
    folder = tmp_path / "results"
    shutil.copytree(made["folder"], folder)
    return Copied(folder, made["table"], partial(made["again"], folder), partial(made["preview"], folder))


def flip(path, share):
    """Flip a bit at a share of a file's length; its size and its date stay."""
    whole, date = bytearray(path.read_bytes()), path.stat().st_mtime_ns
    whole[int(share * (len(whole) - 1))] ^= 4
    path.write_bytes(whole)
    os.utime(path, ns=(date, date))


def runs_to_the_same_table(copied, caplog, damaged):
    """Run again; the table is the same, one line names the damaged file, and nothing is left to do."""
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        store = copied.again()
    assert store.failures().empty
    pd.testing.assert_frame_equal(store.table().drop(columns=list(TIMING)), copied.table)
    lines = [each.getMessage() for each in caplog.records if each.name.startswith("evaluation")]
    if damaged is None:
        assert lines == []
    else:
        assert len(lines) == 1
        assert f"{damaged.parent.name}/{damaged.stem}." in lines[0]
        assert "\n" not in lines[0]
    assert copied.outlook().waiting == {}
    assert store.is_merged()


@pytest.mark.parametrize("pattern", FILES)
def test_a_flipped_bit_in_a_file(pattern, copied, caplog):
    path = sorted(copied.folder.glob(pattern))[0]
    whole = path.read_bytes()
    flip(path, 0.7)
    assert sum(copied.outlook().waiting.values()) == 1
    runs_to_the_same_table(copied, caplog, path)
    assert path.read_bytes() == whole


@pytest.mark.parametrize("pattern", RECORDS)
def test_a_flipped_bit_in_a_record(pattern, copied, caplog):
    path = sorted(copied.folder.glob(pattern))[0]
    flip(path, 0.5)
    runs_to_the_same_table(copied, caplog, path)


@pytest.mark.parametrize("pattern", [FILES[-1], RECORDS[-1]])
@pytest.mark.parametrize("how", ["cut", "empty", "garbled", "deleted"])
def test_other_damage(pattern, how, copied, caplog):
    path = sorted(copied.folder.glob(pattern))[0]
    whole = path.read_bytes()
    if how == "deleted":
        path.unlink()
    else:
        path.write_bytes({"cut": whole[: len(whole) // 2], "empty": b"", "garbled": whole[::-1]}[how])
    unnoted = how == "deleted" and path.suffix == ".json"  # a result without a record was never finished
    runs_to_the_same_table(copied, caplog, None if unnoted else path)


def test_every_kind_of_file_at_once(copied, caplog):
    for pattern in (*FILES, *RECORDS):
        flip(sorted(copied.folder.glob(pattern))[-1], 0.6)
    with caplog.at_level(logging.WARNING):
        store = copied.again()
    pd.testing.assert_frame_equal(store.table().drop(columns=list(TIMING)), copied.table)
    assert "damaged results are made again" in caplog.text


@pytest.mark.parametrize("name", [*MERGED, "run.json"])
@pytest.mark.parametrize("how", ["flipped", "cut", "empty", "garbled", "deleted"])
def test_merged_files_are_written_again(name, how, copied, caplog):
    path = copied.folder / name
    whole = path.read_bytes()
    if how == "flipped":
        flip(path, 0.5)
    elif how == "deleted":
        path.unlink()
    else:
        path.write_bytes({"cut": whole[: len(whole) // 2], "empty": b"", "garbled": whole[::-1]}[how])
    runs_to_the_same_table(copied, caplog, None)


@pytest.mark.parametrize("name", ["table.parquet", "run.json"])
def test_damage_is_seen_by_who_only_reads_and_the_way_out_is_named(name, copied):
    flip(copied.folder / name, 0.5)
    store = ResultsStore(copied.folder)
    with pytest.raises(
        InputError, match=rf"{name}' is damaged .*; medialbench run .* makes it again"
    ) as error:
        store.table() if name == "table.parquet" else store.run_info()
    assert "\n" not in str(error.value)


def test_a_damaged_result_is_not_loaded(copied):
    store = ResultsStore(copied.folder)
    row = store.table().query("kind == 'matching'").iloc[0]
    for stage, key, load in (
        ("scan", row.source_scan, store.scan),
        ("map", row.map_key, store.matching),
    ):
        load(key)
        flip(store.path(stage, key), 0.6)
        with pytest.raises(InputError, match="is damaged"):
            load(key)


def without_checksums(folder):
    """Turn a folder into one of an earlier version."""
    for note in folder.glob("*/*.json"):
        record = json.loads(note.read_text())
        note.write_text(json.dumps({key: record[key] for key in RECORD}))
    info = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps({k: v for k, v in info.items() if k not in (SEAL, "files")}))


def test_results_of_earlier_versions_have_no_checksums_and_are_used(copied, caplog):
    without_checksums(copied.folder)
    assert copied.outlook().waiting == {}
    assert len(ResultsStore(copied.folder).table()) == len(copied.table)
    runs_to_the_same_table(copied, caplog, None)


def test_damage_to_results_of_earlier_versions_is_found_by_the_archive(copied, caplog):
    without_checksums(copied.folder)
    path = sorted(copied.folder.glob("maps/*.npz"))[0]
    flip(path, 0.4)
    runs_to_the_same_table(copied, caplog, path)


@pytest.mark.parametrize("key", ["../../esc", "/etc/x", "..", "", "a/b", "a\\b", ".hidden"])
def test_a_key_from_a_table_is_no_way_out_of_the_folder(key, copied):
    store = ResultsStore(copied.folder)
    for load in (store.scan, store.operator, store.matching, store.shape, store.score):
        with pytest.raises(InputError):
            load(key)
    with pytest.raises(InputError, match="which is no key"):
        store.path("map", key)


def test_a_link_out_of_the_folder_is_not_followed(copied, tmp_path):
    store = ResultsStore(copied.folder)
    key = store.table().query("kind == 'matching'").iloc[0].map_key
    path = store.path("map", key)
    path.rename(tmp_path / "elsewhere.npz")
    path.symlink_to(tmp_path / "elsewhere.npz")
    with pytest.raises(InputError, match="lies outside"):
        store.matching(key)

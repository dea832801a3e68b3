"""Every file of a table says which version, experiment and settings made it."""

from importlib.metadata import version

import pandas as pd
import pyarrow.parquet as pq

from evaluation import merge_results, run
from evaluation.results.origin import Origin, write_csv, write_parquet

TABLE = pd.DataFrame({"method": ["medial", "heat"], "error": [1.25, 2.5]})
ORIGIN = Origin("1.2.3", "quick", "0123456789abcdef")
NOTED = {"medialbench_version": "1.2.3", "experiment": "quick", "config_hash": "0123456789abcdef"}


def test_csv_has_columns_and_parquet_metadata(tmp_path):
    write_csv(TABLE, tmp_path / "t.csv", ORIGIN)
    write_parquet(TABLE, tmp_path / "t.parquet", ORIGIN)
    read = pd.read_csv(tmp_path / "t.csv")
    pd.testing.assert_frame_equal(read[["method", "error"]], TABLE)
    assert read.iloc[1][list(NOTED)].to_dict() == NOTED
    whole = pd.read_parquet(tmp_path / "t.parquet")
    pd.testing.assert_frame_equal(whole, TABLE)
    assert whole.attrs == NOTED
    assert b"0123456789abcdef" in b"".join(pq.read_schema(tmp_path / "t.parquet").metadata.values())
    assert TABLE.attrs == {}


def test_an_empty_table_keeps_its_columns(tmp_path):
    write_csv(TABLE[:0], tmp_path / "t.csv", ORIGIN)
    assert (tmp_path / "t.csv").read_text() == "method,error,medialbench_version,experiment,config_hash\n"


def test_what_earlier_versions_did_not_note_is_left_out():
    assert Origin.of_run({}).line == ""
    assert list(Origin.of_run({}).marked(TABLE)) == ["method", "error"]
    assert Origin.of_run({"experiment": "quick"}).line == "experiment quick"


def test_other_settings_have_another_hash():
    first, again, other = (Origin.of("quick", {"seeds": seeds}) for seeds in ([0], [0], [1]))
    assert first == again
    assert first.config_hash != other.config_hash
    assert first.medialbench_version == version("medialbench")


def test_a_merged_folder_names_all_versions():
    runs = [{"versions": {"medialbench": each}} for each in ("0.2", "0.1", "0.2")]
    info = {"experiment": "quick", "config_hash": "ab", "merged_from": runs}
    assert Origin.of_run(info).line == "medialbench 0.1, 0.2, experiment quick, settings ab"


def test_the_files_of_a_run_and_of_a_merged_one_agree_with_its_note(small, tmp_path):
    store = run(small(seeds=[0]), tmp_path / "out", jobs=1)
    for each in (store, merge_results([store.folder], tmp_path / "merged")):
        info = each.run_info()
        table, failures = (pd.read_csv(each.folder / name) for name in ("table.csv", "failures.csv"))
        assert set(table["config_hash"]) == {info["config_hash"]}
        assert set(table["medialbench_version"]) == {version("medialbench")}
        assert "config_hash" in failures
        assert pd.read_parquet(each.folder / "table.parquet").attrs["config_hash"] == info["config_hash"]
        assert list(each.failures()) == ["key", "stage", "label", "kind", "reason"]
        assert len(table) == len(each.table())

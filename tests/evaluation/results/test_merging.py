import pandas as pd
import pytest

from datasets_gen import InputError
from evaluation import ResultsStore, merge_results, preview, run


@pytest.fixture(scope="module")
def half(tmp_path_factory):
    """The run of one seed; made once."""
    made = {}

    def get(small, seed=0):
        if seed not in made:
            made[seed] = run(small(seeds=[seed]), tmp_path_factory.mktemp("half"), jobs=1)
        return made[seed]

    return get


@pytest.mark.slow
def test_two_machines_make_one_table_and_nothing_is_left_to_run(small, half, tmp_path):
    stores, whole = [half(small, seed) for seed in (0, 1)], small(seeds=[0, 1])
    merged = merge_results([store.folder for store in stores], tmp_path / "both")
    assert preview(whole, merged.folder).waiting == {}
    expected = pd.concat([store.table() for store in stores], ignore_index=True)
    pd.testing.assert_frame_equal(merged.table(), expected)
    row = merged.table().query("kind == 'matching'").iloc[-1]
    assert len(merged.matching(row.map_key)) == row.n_points
    assert merged.collection(row.dataset).subject == "blob"
    again = run(whole, merged.folder, scheduler="tcp://nowhere:1")  # nothing to run: no cluster
    assert len(again.table()) == len(expected)


def test_a_folder_merged_with_itself_is_itself(small, half, tmp_path):
    store = half(small)
    merged = merge_results([store.folder, store.folder], tmp_path / "same")
    pd.testing.assert_frame_equal(merged.table(), store.table())


def test_tables_of_earlier_versions_lack_columns_and_can_be_merged(small, half, tmp_path):
    import shutil

    store, old = half(small), tmp_path / "old"
    shutil.copytree(store.folder, old)
    late = ["oracle_mean", "excess_mean", "gross", "right_limb", "medial_path_mean", "sure_right"]
    late += ["geodesic_best", "probability", "alternatives"]
    store.table().drop(columns=late).to_parquet(old / "table.parquet")
    ResultsStore(old).write_run_info(store.run_info())
    table = merge_results([old], tmp_path / "out").table()
    assert list(table.columns) == list(store.table().columns)
    assert table.dtypes.equals(store.table().dtypes)
    assert table[late].isna().all(axis=None)


def test_what_cannot_be_merged(small, half, tmp_path, blobs):
    store = half(small)
    with pytest.raises(InputError, match="holds files already"):
        merge_results([store.folder], store.folder.parent)
    with pytest.raises(InputError, match=r"no readable experiment|no results"):
        merge_results([tmp_path / "none"], tmp_path / "out")
    with pytest.raises(InputError, match="nothing to merge"):
        merge_results([], tmp_path / "out")


def test_other_conditions_cannot_be_merged(small, half, tmp_path):
    store, other = half(small), tmp_path / "other"
    other.mkdir()
    experiment = small(scan={"points": 200})
    (other / "experiment.toml").write_text(experiment.to_toml())
    with pytest.raises(InputError, match="differ in 'scan'"):
        merge_results([store.folder, other], tmp_path / "out")


def test_different_results_for_one_row_are_refused(small, half, tmp_path):
    import shutil

    store, other = half(small), tmp_path / "other"
    shutil.copytree(store.folder, other)
    table = store.table()
    table["score_key"] = table["score_key"] + "x"
    table.to_parquet(other / "table.parquet")
    ResultsStore(other).write_run_info(store.run_info())
    with pytest.raises(InputError, match="different results for blob"):
        merge_results([store.folder, other], tmp_path / "out")


def test_a_damaged_result_is_taken_from_the_folder_that_has_it_whole(small, half, tmp_path, caplog):
    import shutil

    store, bad = half(small), tmp_path / "bad"
    shutil.copytree(store.folder, bad)
    key = store.table().query("kind == 'matching'").iloc[0].map_key
    damaged = ResultsStore(bad).path("map", key)
    damaged.write_bytes(damaged.read_bytes()[::-1])
    merged = merge_results([bad, store.folder], tmp_path / "out")
    assert len(merged.matching(key)) == len(store.matching(key))
    assert caplog.text.count("left out") == 1
    assert preview(small(seeds=[0]), merged.folder).waiting == {}
    assert merged.is_merged()

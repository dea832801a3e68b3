"""Pages of results that lack something, or whose names are none that a page would choose."""

import numpy as np
import pandas as pd
import pytest

import reports
from datasets_gen import InputError
from evaluation.results.store import ResultsStore, write_json
from reports.figures.pair_pictures import error_note, scan_words
from reports.figures.result_figures import result_figure
from reports.page.headline import headline, overall
from reports.page.pictures import scan_views
from reports.tables.leaderboard import with_numpy_types
from tests.reports.conftest import write_results
from tests.reports.page.test_report import Page

ODD = "a\"b'<i>x</i>&\n[red]{y}|$_\N{HORSE}"


def changed(folder, change):
    """A results folder whose table is changed."""
    store = write_results(folder)
    change(with_numpy_types(store.table())).to_parquet(folder / "table.parquet")
    return store


def without_errors(table, methods=("heat kernel", "medial diffusion")):
    scores = ["geodesic_mean", "geodesic_median", "pck_auc", "matched"]
    table.loc[(table["kind"] == "matching") & table["method"].isin(methods), scores] = np.nan
    return table


def test_a_table_of_an_earlier_version_has_a_page(tmp_path, plain_figures):
    later = ["flipped", "matched", "pck_auc", "geodesic_median", "geodesic_symmetric_mean", "overlap_iou"]
    store = changed(tmp_path, lambda table: table.drop(columns=later))
    page = Page(reports.build(store.folder, pairs=0).read_text())
    assert {"accuracy", "curves", "maps"} <= page.ids
    rows = overall(with_numpy_types(store.table()))
    assert [(row["method"], row["mean"], row["flips"]) for row in rows] == [
        ("medial diffusion", 3.0, None),
        ("heat kernel", 9.0, None),
    ]


def test_a_method_without_errors_is_neither_first_nor_compared(tmp_path):
    table = with_numpy_types(write_results(tmp_path).table())
    table = without_errors(table, ["medial diffusion"])
    assert [row["method"] for row in overall(table)] == ["heat kernel", "medial diffusion"]
    assert headline(table) == ""


def test_maps_without_errors_have_a_page_that_says_so(tmp_path, plain_figures):
    store = changed(tmp_path, without_errors)
    text = reports.build(store.folder, pairs=1).read_text()
    page = Page(text)
    assert "pairs" in page.ids
    assert "chart-missing" not in page.ids
    assert ">nan<" not in text
    with pytest.raises(InputError, match="no map of these results has an error"):
        result_figure("missing", ResultsStore(store.folder))


def test_results_without_times_have_no_figure_of_times(tmp_path):
    store = changed(tmp_path, lambda table: table.drop(columns=["seconds_match", "seconds_operator"]))
    with pytest.raises(InputError, match="hold no times"):
        result_figure("runtime", store)


@pytest.mark.filterwarnings("error")
def test_names_are_shown_as_they_are(tmp_path):
    def odd(table):
        names = ["dataset", "regime", "method", "source_pose", "target_pose", "views"]
        return table.assign(
            **{name: table[name].map(lambda v: f"{v} {ODD}", na_action="ignore") for name in names}
        )

    store = changed(tmp_path, odd)
    table = store.table()
    info = {**store.run_info(), "datasets": {table["dataset"].iloc[0]: "blob-shape"}}
    write_json(tmp_path / "run.json", info)
    index = reports.build(tmp_path, pairs=1)
    text = index.read_text()
    page = Page(text)  # tags are balanced
    assert "<i>" not in text
    assert f"medial diffusion {ODD}" in page.words
    for link in page.links:
        name = link.partition("#")[0]
        assert not name or name.startswith("data:") or (index.parent / name).is_file(), link


def test_what_a_row_lacks_is_not_shown_as_a_number(results):
    store = ResultsStore(results)
    row = with_numpy_types(store.table()).query("kind == 'matching'").iloc[0]
    sampled = store.scan(row["source_scan"])
    assert scan_words(row, "source", sampled) == "sampled, 15 % missing"
    assert scan_words(pd.Series({"source_missing": np.nan}), "source", sampled) == "sampled"
    sampled.view_ids[:] = 0
    assert scan_words(row, "source", sampled) == "τ 0.3, 15 % missing"
    assert error_note({"geodesic_mean": np.nan, "geodesic_median": np.nan}) == "error unknown"
    assert error_note({"geodesic_mean": 2.0}) == "mean 2.0"


def test_samples_of_a_surface_are_no_scans_with_a_threshold(results):
    table = with_numpy_types(ResultsStore(results).table())
    assert len(scan_views(table))
    assert scan_views(table.assign(views="surface")).empty

import re
import shutil
from html.parser import HTMLParser

import pandas as pd
import pytest

import reports
from datasets_gen import InputError
from evaluation.results.store import ResultsStore
from reports.page.headline import headline
from reports.page.pictures import chosen_pairs, evenly_picked, pair_groups, scan_views
from reports.tables.leaderboard import with_numpy_types
from reports.tables.statistics import paired_tests
from tests.reports.conftest import write_results
from tests.reports.tables.small import partial


class Page(HTMLParser):
    """Links, headings and unbalanced tags of a page."""

    VOID = ("meta", "img", "br", "link", "input")

    def __init__(self, text):
        super().__init__()
        self.links, self.ids, self.open, self.words = [], set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.links += [attrs[name] for name in ("href", "src") if attrs.get(name)]
        self.ids |= {attrs["id"]} if "id" in attrs else set()
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


@pytest.fixture(scope="module")
def built(results, tmp_path_factory, plain_figures_of_module):
    seen = []
    out = tmp_path_factory.mktemp("report")
    index = reports.build(results, out, pairs=3, progress=lambda *state: seen.append(state))
    return index, Page(index.read_text()), seen


def test_the_page_explains_columns_for_scans_that_share_little_surface(tmp_path, built, plain_figures):
    store = write_results(tmp_path / "results")
    partial(with_numpy_types(store.table())).to_parquet(store.folder / "table.parquet")
    index = reports.build(store.folder, pairs=0)
    page, plain = Page(index.read_text()), built[1]
    for head in ("least error", "excess", "right limb", "mirror limb", "gross %", "medial path"):
        assert page.words.count(head) >= 2, head  # in the table and among the explanations
        assert plain.words.count(head) <= 1, head  # a column that can be chosen, and then only explained
    assert "least error" in (index.parent / "tables" / "correspondence.md").read_text()


def test_the_page_refers_to_files_beside_it_only_and_all_are_there(built):
    index, page, _ = built
    assert page.open == []
    assert len(page.links) > 10
    for link in page.links:
        if link.startswith("#"):
            assert link[1:] in page.ids
        else:
            assert "://" not in link
            assert link.startswith("data:application/toml;base64,") or (index.parent / link).is_file(), link
    text = index.read_text()
    assert "://" not in re.sub(r"<(pre|script)>.*?</\1>", "", text, flags=re.S)  # a library names its home
    assert not re.search(r"\bfetch\(|XMLHttpRequest|\bimport\(|WebSocket|sendBeacon", text)


def test_everything_asked_for_is_written(built):
    names = {path.name for path in built[0].parent.rglob("*") if path.is_file()}
    for figure in (
        "error-missing",
        "pck-blob",
        "stability-blob",
        "stability-worm",
        "scans-blob",
        "pair-001",
        "pair-003",
    ):
        assert {f"{figure}.png", f"{figure}.pdf"} <= names
    assert "pair-004.png" not in names
    for table in ("correspondence", "stability"):
        assert {f"{table}.md", f"{table}.tex", f"{table}.csv"} <= names
    assert "scores.csv" in names
    assert not [name for name in names if name.startswith(".")]


def test_the_page_says_what_was_found(built):
    words = " ".join(" ".join(built[1].words).split())
    said = (
        "2 pairs of poses are too few to rank medial diffusion and heat kernel: mean geodesic errors 3.5 and"
    )
    assert said in words
    assert "5 more pairs are not drawn" in words
    assert "two <poses>" in words  # escaped in the source, whole for the reader
    assert "numpy" in words


@pytest.mark.parametrize(
    ("second", "said"),
    [
        (
            [1.2, 1.3] * 3,
            "between heat and medial: mean geodesic errors 1.2 and 1.2 (× 100 / √area), difference 0.05",
        ),
        (
            [2.2, 2.3] * 3,
            "The lowest mean geodesic error is that of heat, 1.2 (× 100 / √area), ahead of medial with 2.2",
        ),
        (
            [2.2, 2.3],
            "2 pairs of poses are too few to rank heat and medial: mean geodesic errors 1.2 and 2.2",
        ),
        ([2.2], "On one pair of poses, heat has a mean geodesic error of 1.2 and medial of 2.2"),
    ],
    ids=["tie", "win", "few pairs", "one pair"],
)
def test_the_headline_claims_no_more_than_its_pairs(second, said):
    rows = [
        {"kind": "matching", "dataset": "blob", "regime": regime, "method": method, "geodesic_mean": mean}
        | {"source_pose": "rest", "target_pose": f"p{i}", "seed": 0}
        | {"geodesic_median": mean, "pck_auc": 0.9, "flipped": False}
        for regime in ("easy", "hard")
        for i, value in enumerate(second)
        for method, mean in (("medial", value), ("heat", 1.2))
    ]
    assert said in headline(pd.DataFrame(rows))


def test_the_headline_has_the_numbers_that_compare_prints(results):
    table = with_numpy_types(ResultsStore(results).table())
    said, tests = headline(table), paired_tests(table)
    named = [test for test in tests.to_dict("records") if test["first"] in said and test["second"] in said]
    interval = f"{named[0]['low']:.2f} to {named[0]['high']:.2f}".replace("-", "−")
    assert len(named) == 1
    assert f"{named[0]['difference']:.2f} (95 % interval {interval}" in said


def test_progress_counts_to_the_end(built):
    _, _, seen = built
    done, total = seen[-1][1:]
    assert done == total
    assert [state[1] for state in seen] == list(range(1, total + 1))


@pytest.mark.usefixtures("plain_figures")
def test_failures_are_listed_with_their_reasons(tmp_path):
    write_results(
        tmp_path / "first", failures=[("k", "map", "blob rest to bent cpd", "error", "no <convergence>")]
    )
    folder = shutil.move(tmp_path / "first", tmp_path / "moved")  # results do not know where they lie
    page = Page(reports.build(folder, pairs=0).read_text())
    words = " ".join(page.words)
    assert "no <convergence>" in words
    assert "failures" in page.ids
    assert (folder / "report" / "index.html").is_file()  # the default place


@pytest.mark.usefixtures("plain_figures")
def test_a_run_without_matching_has_a_page(tmp_path):
    store = write_results(tmp_path)
    table = store.table()
    table[table["kind"] == "stability"].to_parquet(tmp_path / "table.parquet")
    page = Page(reports.build(tmp_path).read_text())
    assert "stability" in page.ids
    assert "pairs" not in page.ids


def test_a_folder_without_results_is_refused_in_one_line(tmp_path):
    with pytest.raises(InputError, match="no results table") as caught:
        reports.build(tmp_path, tmp_path / "out")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_pairs_left_out_are_spread_over_data_sets_and_regimes(results):
    maps = with_numpy_types(ResultsStore(results).table())
    maps = maps[maps["kind"] == "matching"]
    assert len(pair_groups(maps)) == 8  # 2 subjects, 2 seeds, 2 thresholds
    assert len(chosen_pairs(maps, None)) == 8
    chosen = chosen_pairs(maps, 4)
    kinds = {(rows.iloc[0]["dataset"], rows.iloc[0]["regime"]) for rows in chosen}
    assert len(kinds) == 4
    assert all(len(rows) == 2 for rows in chosen)  # both methods
    worst = max(pair_groups(maps), key=lambda rows: rows["geodesic_mean"].max())
    assert any(rows.equals(worst) for rows in chosen)
    assert chosen_pairs(maps, 1)[0].equals(worst)


@pytest.mark.usefixtures("plain_figures")
def test_pictures_of_an_earlier_report_do_not_stay(tmp_path):
    write_results(tmp_path / "results")
    for pairs, left in ((1, 1), (0, 0)):
        index = reports.build(tmp_path / "results", pairs=pairs)
        assert len(list((index.parent / "figures").glob("pair-*.png"))) == left


def test_scans_are_found_once_each(results):
    views = scan_views(with_numpy_types(ResultsStore(results).table()))
    assert len(views) == 2 * 2 * 2  # subjects, poses, thresholds of the first seed
    assert set(views["seed"]) == {0}


def test_scans_from_opposite_sides_keep_their_own_views(results):
    table = with_numpy_types(ResultsStore(results).table())
    maps = table[table["kind"] == "matching"].assign(views="front:2", target_views="back:2")
    views = scan_views(maps)  # one of two views that are as frequent
    assert set(views["pose"]) == {"bent"}
    assert set(views["views"]) == {"back:2"}
    older = scan_views(maps.assign(target_views=pd.NA))
    assert set(older["pose"]) == {"bent", "rest"}
    assert set(older["views"]) == {"front:2"}


def test_an_even_pick_keeps_both_ends():
    assert evenly_picked([0.3, 0.1, 0.2], 6) == [0.1, 0.2, 0.3]
    few = evenly_picked([i / 20 for i in range(20)], 6)
    assert len(few) == 6
    assert (few[0], few[-1]) == (0, 0.95)

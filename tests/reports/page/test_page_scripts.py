"""The page's scripts in a real browser: their numbers are those of the results table."""

import html
import json
import re

import pytest

import reports
from evaluation.results.store import ResultsStore
from reports.tables.leaderboard import with_numpy_types
from reports.tables.statistics import nested_mean
from tests.reports.conftest import write_results
from tests.reports.viewer.test_browser import BROWSER, opened

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(BROWSER is None, reason="no Chromium here"),
]

ASK = """<script>window.addEventListener("load", () => {
  const answer = {}, by = (id) => document.getElementById(id);
  const cells = (row) => [...row.children].map((c) => c.textContent);
  const dots = () => document.querySelectorAll("#chart-missing circle[fill-opacity]").length;
  const choose = (text) => {
    const select = by("board-regime");
    select.value = text; select.dispatchEvent(new Event("change"));
  };
  const board = () => [...document.querySelectorAll("#board tbody tr")].map(cells);
  const click = (where) => document.querySelector(where).click();
  answer.heads = cells(document.querySelector("#board thead tr"));
  answer.board = board();
  click("#board thead th:nth-child(2) button"); answer.sorted = board();
  answer.regime = by("board-regime").options[1].value;
  choose(answer.regime); answer.part = board(); choose("");
  answer.dots = dots();
  const numbers = document.querySelectorAll("#chart-missing text[text-anchor=end]");
  answer.ticks = [...numbers].map((text) => Number(text.textContent));
  click("#chart-missing .legend button"); answer.fewer = dots();
  answer.curves = document.querySelectorAll("#chart-pck path").length;
  answer.maps = document.querySelectorAll("#all-maps tbody tr").length;
  answer.worst = cells(document.querySelector("#all-maps tbody tr"));
  answer.wide = document.documentElement.scrollWidth <= window.innerWidth + 1;
  const texts = []; URL.createObjectURL = (blob) => { texts.push(blob); return "data:,"; };
  click("#board-csv"); click("#board-tex");
  Promise.all(texts.map((blob) => blob.text())).then((all) => {
    [answer.csv, answer.tex] = all;
    const node = document.createElement("pre"); node.id = "answer"; node.textContent = JSON.stringify(answer);
    document.body.append(node);
  });
});</script>"""


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return write_results(tmp_path_factory.mktemp("scripts") / "results")


@pytest.fixture(scope="module")
def page(store, tmp_path_factory):
    index = reports.build(store.folder, tmp_path_factory.mktemp("page"), pairs=2)
    asking = index.with_name("asking.html")
    asking.write_text(index.read_text().replace("</body>", f"{ASK}</body>"))
    return asking


@pytest.fixture(scope="module", params=["1400,900", "390,800"], ids=["desk", "phone"])
def answer(request, page, tmp_path_factory):
    dom, complaints = opened(page, tmp_path_factory.mktemp("browser"), "", request.param)
    assert complaints == ""
    found = re.search(r'<pre id="answer">(.*?)</pre>', dom, re.DOTALL)
    assert found, dom[-2000:]
    return json.loads(html.unescape(found[1]))


@pytest.fixture(scope="module")
def maps(store):
    table = with_numpy_types(ResultsStore(store.folder).table())
    return table[table["kind"] == "matching"]


def number(text):
    return float(text.split("±")[0])


def test_means_in_the_page_are_those_of_the_table(answer, maps):
    for rows, part in ((answer["board"], maps), (answer["part"], maps[maps["regime"] == answer["regime"]])):
        ranked = {row[0].rstrip(" †‡"): number(row[1]) for row in rows}
        assert set(ranked) == set(part["method"])
        for method, value in ranked.items():
            wanted = nested_mean(part[part["method"] == method], "geodesic_mean")
            assert value == pytest.approx(wanted, abs=0.0501)


def test_a_click_on_the_head_turns_the_order(answer):
    first = [row[0] for row in answer["board"]]
    assert [row[0] for row in answer["sorted"]] == first[::-1]


def test_every_map_has_a_dot_and_a_row(answer, maps):
    assert answer["dots"] == len(maps)
    assert answer["fewer"] < len(maps)
    assert answer["maps"] == min(50, len(maps))
    assert f"{maps['geodesic_mean'].max():.1f}" in answer["worst"]


def test_a_logarithmic_axis_has_three_numbers_at_least(answer, maps):
    errors = maps["geodesic_mean"]
    assert len(answer["ticks"]) >= 3
    assert errors.min() / 1.2 < min(answer["ticks"]) < max(answer["ticks"]) < errors.max() * 1.2


def test_curves_of_the_first_data_set_and_regime_are_drawn(answer, maps):
    first = maps.iloc[0]
    own = maps[(maps["dataset"] == first["dataset"]) & (maps["regime"] == first["regime"])]
    assert answer["curves"] == own["method"].nunique()


def test_what_is_shown_can_be_saved(answer):
    rows = answer["csv"].strip().splitlines()
    assert rows[0].startswith("method,mean error")
    assert len(rows) == 1 + len(answer["board"])
    assert answer["tex"].startswith("\\begin{tabular}{lr")
    assert "\\bottomrule" in answer["tex"]


def test_the_page_is_no_wider_than_the_window(answer):
    assert answer["wide"]

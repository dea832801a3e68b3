"""Names that people give, with characters that mean something to a format: each comes out as it went in."""

import csv
import io
import shutil
import tomllib

import numpy as np
import pandas as pd
import pytest
from markdown_it import MarkdownIt
from rich.console import Console
from rich.text import Text

import reports
from evaluation import Experiment
from evaluation.results.store import ResultsStore
from reports.figures.pck_curves import pck_curves
from reports.page.pictures import _file_name
from reports.tables.columns import Column, cell_text
from reports.tables.formats import to_latex, to_markdown, write_table
from reports.tables.leaderboard import leaderboard, with_numpy_types
from reports.tables.terminal import leaderboard_lines
from tests.reports.page.test_report import Page
from tests.reports.tables.small import ORIGIN

LABELS = [
    "a [bold] b [/bold]",
    "[/red] closing",
    "back\\slash\\",
    "pipe | and || more",
    "50 % of $x$ and $y_1^2$ {z} #1 ~ & co",
    "_under_score_ __init__",
    "<b>bold</b> <script>alert(1)</script> &lt;",
    "*star* **two** `code` ~~gone~~",
    "[link](http://x) ![i](y)",
    ":heart: and :x:",
    "--scheduler ''quoted''",
    "naïve 汉字 →",
    "=1+1",
    '"quoted", with a comma',
    "NA",
]
LINES = "two\nlines\ttab \x1b[31mred"
SAME = Column("name", "name")


def table_of(labels):
    return pd.DataFrame({"g": "x", "name": labels, "low": range(len(labels))})


COLUMNS = (SAME, Column("low", "low", 1, "low"))


def test_a_cell_is_one_line_without_control_characters():
    assert cell_text(LINES, SAME) == "two lines tab [31mred"


@pytest.mark.parametrize("label", LABELS)
def test_markdown(label):
    made = to_markdown(table_of([label, LINES]), COLUMNS, ["g"])
    assert len(made.splitlines()) == 4
    html = MarkdownIt("commonmark").enable(["table", "strikethrough"]).render(made)
    words = "".join(Page(html).words)
    assert cell_text(label, SAME).strip() in " ".join(words.split())
    assert "<script>" not in html
    assert "<strong>" in html  # of the best number alone
    assert html.count("<strong>") == 1


@pytest.mark.parametrize("label", LABELS)
def test_latex_has_no_bare_special_character(label):
    row = to_latex(table_of([label, LINES]), COLUMNS, ["g"]).splitlines()[4]
    cell = row.rpartition(" & ")[0]
    for bare in ("\\&", "\\%", "\\$", "\\#", "\\_", "\\{", "\\}", "{[}", "{]}", "{*}"):
        cell = cell.replace(bare, "")
    for word in ("backslash", "asciitilde", "asciicircum", "less", "greater", "bar", "asciigrave"):
        cell = cell.replace(f"\\text{word}{{}}", "")
    cell = cell.replace(r"$\to$", "").replace("{}", "")
    assert not set(cell) & set("&%$#_\\[]*~^<>|`{}")


def test_latex_rows_do_not_begin_with_what_belongs_to_the_line_break():
    text = to_latex(table_of(["[1] x", "* y", "a -- b"]), COLUMNS, ["g"])
    assert "\n{[}1{]} x" in text
    assert "\n{*} y" in text
    assert "a -{}- b" in text


@pytest.mark.parametrize("label", LABELS)
def test_csv(tmp_path, label):
    path = write_table(table_of([label, LINES]), COLUMNS, ["g"], tmp_path, "t", ORIGIN)["csv"]
    with path.open(newline="", encoding="utf-8") as stream:
        assert [row["name"] for row in csv.DictReader(stream)] == [label, LINES]


@pytest.fixture
def named(results, tmp_path):
    """The results folder with other names for a method, a regime and a data set."""

    def make(method, regime="threshold 0.3", dataset="blob"):
        folder = tmp_path / "results"
        shutil.copytree(results, folder)
        table = pd.read_parquet(folder / "table.parquet")
        table["method"] = table["method"].replace("heat kernel", method)
        table["regime"] = table["regime"].replace("threshold 0.3", regime)
        table.to_parquet(folder / "table.parquet")
        return folder

    return make


@pytest.mark.parametrize("label", LABELS)
def test_terminal(label, results):
    board = leaderboard(with_numpy_types(ResultsStore(results).table()))
    board["method"] = board["method"].replace("heat kernel", label)
    board["regime"] = label
    console = Console(file=io.StringIO(), width=200, highlight=False, force_terminal=True)
    for line in leaderboard_lines(board, 80):
        console.print(line, soft_wrap=True, emoji=False)
    shown = Text.from_ansi(console.file.getvalue()).plain.splitlines()
    assert f"blob, {label}" in shown
    assert [line for line in shown if line.startswith(label)]
    widths = {len(Text(line).plain) for line in shown if line.rstrip().endswith(("0.0300", "0.1200"))}
    assert len(widths) <= 1 or "汉" in label


@pytest.mark.usefixtures("plain_figures")
@pytest.mark.parametrize(
    ("label", "pairs"),
    [
        (LABELS[4], 1),
        (LINES, 0),
        pytest.param(LABELS[6], 0, marks=pytest.mark.slow),
        pytest.param("_under", 0, marks=pytest.mark.slow),
    ],
)
def test_the_report_and_its_figures(named, label, pairs):
    page = Page(reports.build(named(label, label), pairs=pairs).read_text(encoding="utf-8"))
    words = " ".join(" ".join(page.words).split())
    assert " ".join(cell_text(label, SAME).split()) in words


def test_legends_show_names_with_an_underscore_and_dollars():
    curves = {"$g$": {"_mine": [0, 1], "$x$ and $\\bad$": [0, 1]}}
    lines = {g: {m: np.array(v) for m, v in each.items()} for g, each in curves.items()}
    figure = pck_curves(lines, np.array([0.5, 1.0]))
    figure.canvas.draw()
    assert {text.get_text().lstrip("\u200b") for text in figure.legends[0].get_texts()} == set(curves["$g$"])


def test_file_names_are_plain_and_differ():
    given = ["blob", "a b", "a-b", "A-b", "../../x", "a/b", "汉字", "x" * 300, "y" * 300, "con.", ""]
    names = [_file_name(each) for each in given]
    assert names[0] == "blob"
    assert len({name.lower() for name in names}) == len(names)
    assert all(
        len(name) < 80 and set(name) <= set("abcdefghijklmnopqrstuvwxyz0123456789-_") for name in names
    )


def test_experiments_keep_their_names():
    methods = [{"name": "heat", "label": label} for label in [*LABELS, LINES]]
    experiment = Experiment.from_table(
        {"name": "x", "dataset": [{"name": "human"}], "matching": {}, "method": methods}
    )
    again = Experiment.from_table(tomllib.loads(experiment.to_toml()))
    assert [each.label for each in again.method] == [*LABELS, LINES]

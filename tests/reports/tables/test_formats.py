import csv
import io

from evaluation.results.origin import Origin
from evaluation.results.store import ResultsStore
from reports.tables.columns import GROUP, LEADERBOARD
from reports.tables.formats import to_latex, to_markdown, write_table
from reports.tables.leaderboard import leaderboard, with_numpy_types
from tests.reports.tables.small import COLUMNS, ORIGIN, SMALL


def test_markdown_is_a_table_with_every_cell():
    lines = to_markdown(SMALL, COLUMNS, ["g"]).splitlines()
    assert lines[0] == "| name & co | low_1 | ± |"
    assert lines[1] == "| --- | ---: | ---: |"
    assert lines[2] == r"| a\|b | **1.0** | 0.50 |"
    assert lines[4] == "| c | 2.0 | 0.10 |"
    assert lines[5] == "| d | – | 0.70 |"


def test_latex_escapes_and_separates_groups():
    text = to_latex(SMALL, COLUMNS, ["g"])
    assert r"name \& co & low\_1 & $\pm$ \\" in text
    assert r"50 \% \#1 & \textbf{1.0} & \textbf{0.90} \\" in text
    assert text.count(r"\midrule") == 2
    assert text.count("&") - text.count(r"\&") == 2 * 6


def test_csv_keeps_full_precision(tmp_path, results):
    board = leaderboard(with_numpy_types(ResultsStore(results).table()))
    paths = write_table(board, LEADERBOARD, GROUP, tmp_path, "t", ORIGIN)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["t.csv", "t.md", "t.tex"]
    rows = list(csv.DictReader(io.StringIO(paths["csv"].read_text())))
    assert len(rows) == len(board)
    assert float(rows[0]["pck_auc"]) == board["pck_auc"][0]


def test_every_format_says_where_the_table_comes_from(tmp_path):
    paths = write_table(SMALL, COLUMNS, ["g"], tmp_path, "t", ORIGIN)
    line = "medialbench 1.2.3, experiment a_b & 50 %, settings 0123456789abcdef"
    first, second = paths["tex"].read_text().splitlines()[:2]
    assert first == f"% {line}"
    assert second.startswith(r"\begin{tabular}")
    text = paths["md"].read_text()
    assert text.endswith("\n\nmedialbench 1.2.3, experiment a\\_b &amp; 50 %, settings 0123456789abcdef\n")
    assert text.startswith(to_markdown(SMALL, COLUMNS, ["g"]))
    rows = list(csv.DictReader(io.StringIO(paths["csv"].read_text())))
    assert list(rows[0])[:3] == ["name", "low", "high"]
    assert {row["medialbench_version"] for row in rows} == {"1.2.3"}
    assert {row["config_hash"] for row in rows} == {"0123456789abcdef"}


def test_results_of_unknown_origin_have_plain_tables(tmp_path):
    paths = write_table(SMALL, COLUMNS, ["g"], tmp_path, "t", Origin())
    assert paths["md"].read_text() == to_markdown(SMALL, COLUMNS, ["g"])
    assert paths["tex"].read_text() == to_latex(SMALL, COLUMNS, ["g"])
    assert paths["csv"].read_text().splitlines()[0] == "name,low,high"

"""The commands that read a results folder."""

import os
import shutil
import subprocess
import sys

import pytest
from click.testing import CliRunner

from evaluation.results.store import FORMAT
from reports.cli.main import cli
from reports.tables.terminal import leaderboard_lines
from tests.reports.conftest import write_results


def run(*arguments):
    return CliRunner().invoke(cli, [str(a) for a in arguments])


@pytest.fixture(scope="module")
def little(tmp_path_factory):
    """Results of one subject and seed."""
    folder = tmp_path_factory.mktemp("little")
    write_results(folder)
    return folder


@pytest.mark.usefixtures("plain_figures")
def test_report_ends_with_the_path_of_the_page(little, tmp_path):
    result = run("report", little, "-o", tmp_path / "out", "--pairs", "1", "-j", "1")
    assert result.exit_code == 0, result.output
    assert result.stdout.strip() == str(tmp_path / "out" / "index.html")
    assert (tmp_path / "out" / "index.html").is_file()
    assert len(list((tmp_path / "out" / "figures").glob("pair-*.png"))) == 1


@pytest.mark.slow
@pytest.mark.long
def test_report_with_several_processes_is_the_same(results, tmp_path):
    for jobs in (1, 2):
        result = run("report", results, "-o", tmp_path / str(jobs), "--pairs", "2", "-j", jobs, "-q")
        assert result.exit_code == 0, result.output
    files = [path for path in (tmp_path / "1").rglob("*") if path.is_file()]
    assert len(files) > 20
    for path in files:
        other = tmp_path / "2" / path.relative_to(tmp_path / "1")
        assert other.read_bytes() == path.read_bytes(), path.name


def test_compare_shows_the_leaderboard_with_spread_and_tests(results):
    result = run("compare", results)
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    at = lines.index("blob, threshold 0.3")
    best, second = lines[at + 1].split(), lines[at + 2].split()
    assert best[:2] == ["medial", "diffusion"]
    wanted = [
        "2",
        "15",
        "3.5",
        "100",
        "0.7",
        "3.0",
    ]  # maps, missing, mean, matched, spread over seeds, median
    assert best[2:8] == wanted
    assert second[:2] == ["heat", "kernel"]
    tests = next(line for line in lines if line.startswith("medial diffusion  heat kernel"))
    # difference, interval, pairs of poses, of which better and tied; too few for a p-value
    assert tests.split()[4:] == ["6.00", "6.00", "to", "6.00", "2", "2", "0", "–"]


def test_compare_needs_correspondences(tmp_path):
    store = write_results(tmp_path)
    table = store.table()
    table[table["kind"] == "stability"].to_parquet(tmp_path / "table.parquet")
    result = run("compare", tmp_path)
    assert result.exit_code == 1
    assert result.stderr.startswith("medialbench: ")
    assert "no correspondences" in result.stderr


@pytest.mark.parametrize("width", [80, 200])
def test_leaderboards_fit_a_narrow_terminal(results, width):
    import re

    from evaluation.results.store import ResultsStore
    from reports.tables.leaderboard import leaderboard, with_numpy_types

    board = leaderboard(with_numpy_types(ResultsStore(results).table()))
    lines = [re.sub(r"\[/?[a-z]*\]", "", line) for line in leaderboard_lines(board, width)]
    assert max(map(len, lines)) <= width
    assert ("maps" in lines[1]) == (width == 200)


def test_results_of_another_format_are_refused(tmp_path):
    write_results(tmp_path)
    info = (tmp_path / "run.json").read_text().replace(f'"format": {FORMAT}', '"format": 99')
    (tmp_path / "run.json").write_text(info)
    result = run("report", tmp_path)
    assert result.exit_code == 1
    assert "99" in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize("damage", ["text", "folder"])
def test_a_damaged_note_of_the_run_is_said(results, tmp_path, damage):
    """The leaderboard came without a word."""
    folder = tmp_path / "copy"
    shutil.copytree(results, folder)
    note = folder / "run.json"
    if damage == "folder":
        note.unlink()
        note.mkdir()
    else:
        note.write_text(note.read_text()[:-20])
    result = run("compare", folder)
    assert result.exit_code == 1
    assert "run.json' is damaged" in result.stderr


def test_data_sets_and_seeds_replace_those_of_a_preset():
    from reports.cli.experiment_argument import load_experiment

    assert load_experiment("matching").seeds == (0, 1, 2)
    changed = load_experiment("matching", ("human_asymmetric",), 2)
    assert changed.seeds == (0, 1)
    assert [(each.name, each.poses) for each in changed.dataset] == [("human_asymmetric", 4)]


def test_a_built_in_body_is_meant_by_its_name_and_a_folder_called_alike_by_its_path(tmp_path, monkeypatch):
    """``medialbench datasets human -o human/`` is the README's own first command."""
    from evaluation.experiment.experiment import Experiment
    from evaluation.experiment.make_plan import shape_tasks
    from reports.cli.experiment_argument import load_experiment

    monkeypatch.chdir(tmp_path)
    (tmp_path / "human").mkdir()
    (tmp_path / "human" / "rest.ply").write_text("not read")
    file = tmp_path / "own.toml"
    file.write_text('name = "own"\n[[dataset]]\nname = "human"\n[stability]\n')
    for experiment in (load_experiment("matching", ("human",)), Experiment.load(file)):
        assert [each.name for each in experiment.dataset] == ["human"]
        assert shape_tasks(experiment)["human"].spec["name"] == "human"
    for path in ("human/", "./human"):
        experiment = load_experiment("matching", (path,))
        assert [each.name for each in experiment.dataset] == [str(tmp_path / "human")]


@pytest.mark.parametrize(
    ("wanted", "labels"),
    [
        (("heat kernel",), ["heat kernel"]),  # a label alone, though other methods have the name
        (("heat",), ["heat kernel", "heat kernel (paper)"]),
        (("tufted Laplacian", "heat kernel"), ["heat kernel", "tufted Laplacian"]),
    ],
)
def test_methods_are_chosen_by_label_or_by_name(wanted, labels):
    from reports.cli.experiment_argument import load_experiment

    assert [each.label for each in load_experiment("opposite", methods=wanted).method] == labels


def test_a_method_that_the_experiment_lacks_is_refused_with_those_it_has():
    result = run("run", "opposite", "--method", "cpd", "--dry-run")
    assert result.exit_code == 1
    assert "'opposite' has no method 'cpd'; it has 'medial diffusion', " in result.stderr


def test_a_terminal_that_is_not_utf_8_gets_its_table(results):
    code = "from reports.cli.main import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code, "compare", str(results)],
        capture_output=True,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
        check=True,
    )
    assert b"medial diffusion" in done.stdout
    assert b"errors ? 100" in done.stdout

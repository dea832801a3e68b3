import importlib.util

import pandas as pd
import pytest

from reports.cli.figure import LAST, OF_RESULTS, STEPS
from reports.figures.paper_figures import FIGURES
from reports.figures.result_figures import FILES, MAKERS
from tests.reports.cli.command_line import fails, run


def test_a_figure_is_written_as_three_files(here):
    result = run("figure", 4, "--dataset", "dumbbell", "--points", 300, "--seed", 2, "-o", "out", "-q")
    assert result.exit_code == 0, result.output
    names = sorted(path.name for path in (here / "out").iterdir())
    assert names == [f"figure-4-diffusion-over-time.{suffix}" for suffix in ("csv", "pdf", "png")]
    assert result.stdout.split() == [f"out/{name}" for name in (names[2], names[1], names[0])]
    table = pd.read_csv(here / "out" / names[0])
    assert table["config_hash"].nunique() == 1
    assert result.stderr == ""


def test_a_figure_of_results_is_written_with_them(results, here):
    result = run("figure", "failures", results, "-o", "out")
    assert result.exit_code == 0, result.output
    assert (here / "out" / "failure-rates.csv").is_file()


def test_every_figure_is_known_to_the_command():
    assert set(FIGURES) == set(STEPS) == set(range(1, LAST + 1))
    assert set(OF_RESULTS) == set(MAKERS) == set(FILES)


@pytest.mark.parametrize("number", sorted(set(FIGURES) - {10}))
def test_every_figure_has_its_module(number):
    assert importlib.util.find_spec(f"reports.figures.{FIGURES[number].name}")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["12"], "1 to 11"),
        (["tables"], "no figure 'tables'"),
        (["pck"], "give their folder"),
        (["4", "somewhere"], "no figure '4' of results"),
        (["pck", "somewhere", "--points", "500"], "not for figures of results"),
        (["1", "-t", "high"], "no list of numbers"),
    ],
    ids=["number", "name", "no folder", "number of results", "options of results", "threshold"],
)
def test_calls_that_mean_nothing_are_refused_in_a_line(arguments, words, here):
    fails(run("figure", *arguments), words, status=2)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["4", "--dataset", "nothing"], "no dataset 'nothing'"),
        (["4", "--points", "3"], "points is 3"),
        (["9", "--dataset", "dumbbell", "--poses", "arc"], "2 poses"),
        (["pck", "nowhere"], "nowhere"),
    ],
    ids=["dataset", "points", "poses", "results"],
)
def test_what_cannot_be_drawn_is_said_in_a_line(arguments, words, here):
    fails(run("figure", *arguments), words)

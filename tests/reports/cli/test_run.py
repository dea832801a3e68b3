"""Experiments from shapes to report."""

import re
from pathlib import Path

import pytest

from tests.reports.cli.command_line import body, fails, run


def test_experiments_that_cannot_run_are_refused(tmp_path):
    out = tmp_path / "out"
    unknown = tmp_path / "unknown.toml"
    unknown.write_text('name = "x"\nseads = [1]\n[[dataset]]\nname = "human"\n')
    broken = tmp_path / "broken.toml"
    broken.write_text("name = \n")
    fails(run("run", "quik", "-o", out), "quik", "quick")
    fails(run("run", unknown, "-o", out), "seads", "seeds")
    fails(run("run", broken, "-o", out), "broken.toml")
    fails(run("run", tmp_path / "none.toml", "-o", out), "none.toml")
    fails(run("run", "quick", "-o", out, "--dataset", "humen", "--dry-run"), "humen")
    assert not out.exists()


def test_folders_that_are_no_experiments_are_pointed_to_the_right_command(here):
    body().export(here / "rest.ply")
    fails(run("run", here), "folder of meshes", f"medialbench run quick --dataset {here}")
    (here / "empty").mkdir()
    fails(run("run", "empty"), "no experiment.toml", "quick")


def test_dry_runs_write_nothing(tmp_path):
    result = run("run", "quick", "-o", tmp_path / "out", "--dry-run", "--jobs", "3")
    assert result.exit_code == 0, result.output
    total = re.search(r"(\d+) tasks to run, about [0-9:]+ with 3 workers", result.output)
    counts = [int(count) for count in re.findall(r"(\d+) to run\n", result.output)]
    assert int(total[1]) == sum(counts) > 0
    assert list(tmp_path.iterdir()) == []


SWEEP = """
name = "tiny"
seeds = [0]
evaluated = 50
[[dataset]]
name = "{folder}"
[scan]
views = 4
points = 300
scanner = {{ resolution = [60, 60], stripes = 80 }}
[operators]
modes = 20
[stability]
operators = ["heat"]
sweep = {{ threshold = [0.3] }}
[matching]
[[matching.regime]]
name = "easy"
threshold = 0.3
[[method]]
name = "heat"
label = "heat kernel"
"""


def test_an_experiment_in_the_results_folder_is_not_overwritten(tmp_path):
    config = tmp_path / "experiment.toml"
    config.write_text(SWEEP.format(folder="human"))
    fails(run("run", config, "-o", tmp_path), "overwrite its input", "-o")
    assert config.read_text() == SWEEP.format(folder="human")
    assert list(tmp_path.iterdir()) == [config]


def test_folders_without_results_are_refused(tmp_path):
    for command in ("report", "compare"):
        fails(run(command, tmp_path / "none"), "none")
        fails(run(command, tmp_path), "no results")
    fails(run("merge", tmp_path / "none", "-o", tmp_path / "joint"), "none")
    fails(run("merge", "-o", tmp_path / "joint"), "DIR", status=2)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("plain_figures")
def test_a_run_ends_with_the_leaderboard_and_the_report_and_goes_on_from_what_is_stored(tmp_path):
    poses = tmp_path / "club"
    poses.mkdir()
    straight, bent = body(), body()
    bent.vertices[:, 0] += 0.1 * bent.vertices[:, 1] ** 2
    straight.export(poses / "rest.ply")
    bent.export(poses / "bent.ply")
    config, out = tmp_path / "tiny.toml", tmp_path / "out"
    config.write_text(SWEEP.format(folder=poses))
    result = run("run", config, "-o", out, "--jobs", "1")
    assert result.exit_code == 0, result.output
    assert "club, easy" in result.stdout
    assert "heat kernel" in result.stdout
    page = out.resolve() / "report" / "index.html"
    assert result.stdout.splitlines()[-1] == str(page)
    assert page.is_file()
    dry = run("run", config, "-o", out, "--dry-run")
    assert "nothing to run" in dry.stdout
    assert "nothing to run" in run("run", out, "--dry-run").stdout  # a results folder is its experiment
    fails(run("compare", tmp_path), "out", f"medialbench compare {out}")
    fails(run("report", tmp_path), f"medialbench report {out}")
    before = (out / "table.csv").read_bytes()
    again = run("run", config, "-o", out, "--no-report", "-q")
    assert again.exit_code == 0
    assert (out / "table.csv").read_bytes() == before
    joint = run("merge", out, "-o", tmp_path / "joint")
    assert joint.exit_code == 0, joint.output
    assert run("compare", tmp_path / "joint").exit_code == 0


def test_poses_are_a_number_or_names(tmp_path):
    for poses, said in (("2", "human: rest, "), ("rest, sit", "human: rest, sit\n"), ("all", "walk")):
        result = run("run", "quick", "-o", tmp_path, "--dataset", "human", "--poses", poses, "--dry-run")
        assert said in result.output, result.output
    fails(run("run", "quick", "-o", tmp_path, "--poses", "rest,sitt", "--dry-run"), "'sitt'", "'sit'")
    fails(run("run", "quick", "-o", tmp_path, "--poses", "0", "--dry-run"), "poses", "0")


def test_the_help_names_every_preset():
    from evaluation import presets

    text = " ".join(run("run", "--help").output.split()).replace("- ", "-")
    assert all(name in text for name in presets())


def test_a_dry_run_needs_no_folder_to_write_to(tmp_path, monkeypatch):
    monkeypatch.setattr("os.access", lambda *_: False)
    result = run("run", "quick", "-o", tmp_path / "out", "--dry-run")
    assert result.exit_code == 0, result.output
    fails(run("run", "quick", "-o", tmp_path / "out"), "no permission")


def test_the_name_of_an_experiment_is_no_way_out_of_the_results(here, monkeypatch):
    import importlib

    import click

    chosen = []

    def stop(settings, folder, quiet, **options):
        chosen.append(folder)
        raise click.ClickException("stopped by the test")

    monkeypatch.setattr(importlib.import_module("reports.cli.run"), "_sweep", stop)
    text = '[[dataset]]\nname = "human"\n[stability]\noperators = ["heat"]\n'
    for name in ("../../esc", "/abs", "..", "plain"):
        (here / "e.toml").write_text(f'name = "{name}"\n{text}')
        fails(run("run", "e.toml"), "stopped by the test")
    assert {folder.parent for folder in chosen} == {Path("results")}
    assert chosen[-1] == Path("results/plain")
    assert all(folder.name not in ("..", ".") for folder in chosen)


def test_certificates_go_with_a_scheduler(here):
    fails(
        run("run", "quick", "--tls-ca", "ca.pem"),
        "--scheduler, --tls-ca and --tls-cert go together",
        status=2,
    )
    fails(run("run", "quick", "--tls-cert", "a.pem", "--scheduler", "tls://a:1"), "go together", status=2)

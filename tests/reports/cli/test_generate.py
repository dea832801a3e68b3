"""``medialbench generate``."""

import re

import pytest

from tests.reports.cli.command_line import body, fails, run

CONFIG = """
[[dataset]]
name = "club"
[scan]
points = 100
views = 3
scanner = { resolution = [60, 60], stripes = 80 }
[draw]
threshold = [0.2, 0.6]
per_render = 2
"""


@pytest.fixture
def config(here):
    (here / "club").mkdir()
    mesh = body()
    mesh.export(here / "club" / "rest.ply")
    mesh.apply_scale([1.0, 1.1, 1.0])
    mesh.export(here / "club" / "long.ply")
    (here / "clubs.toml").write_text(CONFIG)
    return here / "clubs.toml"


def test_what_cannot_be_made_is_refused(here):
    fails(run("generate", "quik", "-n", 10), "quik", "did you mean 'quick'")
    fails(run("generate", "none.toml", "-n", 10), "none.toml", "presets: bodies, quick")
    fails(run("generate", "quick"), "--samples", status=2)
    fails(run("generate", "quick", "-n", 0), "0", status=2)
    fails(run("generate", "quick", "-n", 10, "--tls-ca", "x"), "go together", status=2)
    (here / "file").write_text("")
    fails(run("generate", "quick", "-n", 10, "-o", "file"), "not a folder")
    assert [each.name for each in here.iterdir()] == ["file"]


def test_dry_runs_write_nothing(here):
    result = run("generate", "quick", "-n", 250, "--jobs", 3, "--dry-run")
    assert result.exit_code == 0, result.output
    assert "human: 5 individuals, 1 of them to validate with" in result.output
    assert "200 samples to train with, 50 to validate with" in result.output
    assert re.search(r"3 shards to make, 0 are there; at most \d+ MB", result.output)
    assert re.search(r"about [0-9:]+ with 3 workers", result.output)
    assert list(here.iterdir()) == []


@pytest.mark.slow
def test_from_a_file_to_a_datasheet(config, here):
    result = run("generate", config, "-n", 6, "--shard-size", 4, "-j", 1)
    assert result.exit_code == 0, result.output
    folder = here / "training" / "clubs"
    assert str(folder / "DATASHEET.md") in result.output
    assert "6 samples" in result.stderr
    assert len(list(folder.glob("train-*.tar"))) == 2
    again = run("generate", config, "-n", 6, "--shard-size", 4, "-j", 1)
    assert "0 made now" in again.stderr
    config.write_text(CONFIG.replace("points = 100", "points = 90"))
    fails(run("generate", config, "-n", 6, "-q"), "scan.points was 100, is 90", "--force")
    config.write_text(CONFIG.replace("threshold = [0.2", "threshold = [0.99").replace("0.6]", "1.0]"))
    fails(
        run("generate", config, "-n", 6, "-j", 1, "-q", "--force"), "of 6 samples are missing", "failures.csv"
    )

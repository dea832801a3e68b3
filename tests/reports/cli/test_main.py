"""The command line as a whole: help, suggestions, failures in one line."""

import logging
import subprocess
import sys

import pytest

import scanner_sim
from reports.cli.console import log_messages
from reports.cli.main import COMMANDS
from tests.reports.cli.command_line import fails, run


def test_help_starts_without_heavy_libraries():
    code = (
        "import sys; from click.testing import CliRunner; from reports.cli.main import cli;"
        "result = CliRunner().invoke(cli, ['--help']); assert result.exit_code == 0;"
        "heavy = ('numpy', 'scipy', 'mitsuba', 'pandas', 'matplotlib', 'dask');"
        "print([m for m in heavy if m in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_help_lists_every_command_with_a_sentence():
    lines = run("--help").output.splitlines()
    for name in COMMANDS:
        line = next(line for line in lines if line.split()[:1] == [name])
        assert line.rstrip().endswith(".")
        assert not line.rstrip().endswith("...")


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_the_common_options(name):
    text = run(name, "--help").output
    for option in ("--quiet", "--debug", "--help"):
        assert option in text


def test_without_a_command_the_help_is_printed():
    result = run()
    assert result.exit_code == 0
    assert result.stdout == run("--help").stdout


@pytest.mark.parametrize(("typed", "meant"), [("doctr", "doctor"), ("mach", "match"), ("compair", "compare")])
def test_unknown_commands_name_the_nearest(typed, meant):
    fails(run(typed), typed, f"did you mean {meant!r}?", "medialbench --help", status=2)


def test_unknown_commands_like_none_name_all():
    fails(run("zzz"), "zzz", *COMMANDS, status=2)


def test_wrong_usage_is_one_line():
    fails(run("scam"), "scam", "--help", status=2)
    fails(run("scan", "--colour", "x.ply"), "--colour", "medialbench scan --help", status=2)
    fails(run("match", "x.ply"), "TARGET", status=2)
    fails(run("report"), "DIR", status=2)
    fails(run("report", "x", "--pairs", "many"), "many", status=2)
    fails(run("scan", "x.ply", "-o", "y.npz", "--points", "0"), "0", status=2)


def test_unexpected_errors_are_one_line_and_whole_with_debug(monkeypatch, mesh_file, tmp_path):
    def broken(*_):
        raise RuntimeError("no\nluck")

    monkeypatch.setattr(scanner_sim, "scan", broken)
    out = tmp_path / "o.npz"
    fails(run("scan", mesh_file, "-o", out), "RuntimeError", "no luck", "--debug")
    result = run("scan", mesh_file, "-o", out, "--debug")
    assert isinstance(result.exception, RuntimeError)
    assert not out.exists()


def test_the_installed_command_ends_with_a_status_and_one_line(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "reports.cli.main", "scan", "no.ply", "-o", "x.npz"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr == "medialbench: 'no.ply' does not exist; give a mesh file\n"
    assert list(tmp_path.iterdir()) == []


def test_a_warning_is_said_once(capsys):
    with log_messages(quiet=False):
        for _ in range(2):
            logging.getLogger("medial.somewhere").warning("the ice is thin")
        logging.getLogger("another.library").warning("not ours")
    assert capsys.readouterr().err == "warning: the ice is thin\n"

"""Clocks that jump, and a limit of open files that is too low."""

import re
import sys
import time

import pytest

from tests.faults.sweep import check_finished, ended, run_here, started

YEAR = 31557600.0
YEARS = (-30, -1, 1, 30)


def finished(settings, folder, monkeypatch, expected):
    """The undisturbed table; the same command again has nothing to do."""
    check_finished(folder, expected)
    before = (folder / "run.json").read_bytes()
    run_here(settings, folder, monkeypatch)
    assert (folder / "run.json").read_bytes() == before


@pytest.mark.parametrize("years", YEARS)
def test_clocks_that_jump_while_a_sweep_runs(years, settings, undisturbed, tmp_path, monkeypatch, injected):
    """At every reading of the clock from the second on."""
    clock, read = time.time, []

    def jumping():
        read.append(1)
        return clock() + (years * YEAR if len(read) > 1 else 0.0)

    with monkeypatch.context() as patch:
        patch.setattr(time, "time", jumping)
        run_here(settings[0], tmp_path / "results", monkeypatch)
    injected("clock")
    finished(settings[0], tmp_path / "results", monkeypatch, undisturbed)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("years", YEARS)
@pytest.mark.parametrize("seconds", [0.0, 4.0])
def test_clocks_of_all_processes_that_jump(
    years, seconds, settings, undisturbed, tmp_path, monkeypatch, injected
):
    """Dask's, too, from the start of each process or some seconds later."""
    clock = {"MEDIALBENCH_TEST_CLOCK": f"{seconds},{years}"}
    process = started(settings[1], tmp_path / "results", seconds=0.2, start=True, env=clock)
    assert ended(process) == ("", 0)
    injected("clock")
    finished(settings[0], tmp_path / "results", monkeypatch, undisturbed)


def limited(soft, hard):
    """What sets the limit of open files of a process as it starts."""
    resource = pytest.importorskip("resource")
    return lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@pytest.mark.skipif(sys.platform != "linux", reason="limits differ")
@pytest.mark.parametrize(
    "files", [60, *(pytest.param(n, marks=(pytest.mark.slow, pytest.mark.long)) for n in (20, 30, 40, 79))]
)
def test_too_few_open_files(files, settings, undisturbed, tmp_path, monkeypatch, injected):
    """One line says what to do, before any work is done."""
    folder = tmp_path / "results"
    said, status = ended(started(settings[1], folder, preexec_fn=limited(files, files)))
    assert re.fullmatch(
        rf"medialbench: only {files} files may be open at once, 1 workers need 80; raise the limit .*\n", said
    )
    assert status == 1
    injected("open files")
    run_here(settings[0], folder, monkeypatch)
    check_finished(folder, undisturbed)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="limits differ")
@pytest.mark.parametrize(("soft", "hard"), [(80, 80), (40, 4096)])
def test_a_limit_that_can_be_raised_is(soft, hard, settings, undisturbed, tmp_path, injected):
    folder = tmp_path / "results"
    assert ended(started(settings[1], folder, preexec_fn=limited(soft, hard))) == ("", 0)
    injected("open files")
    check_finished(folder, undisturbed)

"""Progress in lines and on a terminal: what remains falls while a step runs."""

import io
import time
from types import SimpleNamespace

import pytest
from rich.console import Console

from reports.cli import progress
from reports.cli.progress import ProgressBar, SweepProgress, clock


@pytest.fixture
def now(monkeypatch):
    """A clock that stands still until it is moved."""
    seconds = [100.0]
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: seconds[0]))
    return seconds


def test_what_remains_follows_the_mean_speed_and_falls_while_a_step_runs(now):
    bar = ProgressBar(10, "matching", quiet=True)
    assert bar.remaining() == "time remaining unknown"
    now[0] += 20
    bar.advance(2)
    assert bar.remaining() == "about 1:20 remaining"
    now[0] += 30
    assert bar.remaining() == "about 0:50 remaining"
    now[0] += 60
    assert bar.remaining() == "time remaining unknown"  # it takes longer than expected
    bar.advance(8)
    assert bar.remaining() == "time remaining unknown"


def test_lines_are_printed_at_intervals_although_nothing_moves(monkeypatch, capsys):
    monkeypatch.setattr(progress, "SECONDS_PER_LINE", 0.05)
    with ProgressBar(4, "reading", quiet=False) as bar:
        bar.advance(1)
        time.sleep(0.2)
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) >= 2
    assert all(line.startswith("reading: 25 %, 0:00 passed, ") for line in lines)
    assert all("remaining" in line or "almost done" in line for line in lines)


def test_quiet_bars_print_nothing(monkeypatch, capsys):
    monkeypatch.setattr(progress, "SECONDS_PER_LINE", 0.01)
    with ProgressBar(4, "reading", quiet=True) as bar:
        bar.advance(1)
        time.sleep(0.05)
    assert capsys.readouterr() == ("", "")


def test_on_a_terminal_there_is_a_bar(monkeypatch):
    stream = io.StringIO()
    console = Console(file=stream, force_terminal=True, width=100)
    monkeypatch.setattr(progress, "error_console", lambda: console)
    with ProgressBar(4, "reading", quiet=False, remaining=lambda: 65.0) as bar:
        bar.advance(1)
    assert "about 1:05 remaining" in stream.getvalue()
    assert "25%" in stream.getvalue()


def outcome(stage, ok=True):
    task = SimpleNamespace(stage=stage, label=f"{stage} of blob")
    return SimpleNamespace(task=task, ok=ok, kind="" if ok else "error", reason="no luck", seconds=2.0)


def test_sweeps_count_tasks_and_name_failures_at_once(capsys):
    sweep = SweepProgress()
    sweep.begin({"scan": 2, "map": 1}, 4, 2, "")
    sweep.advance(outcome("scan"))
    assert sweep._bar._description.startswith("1 of 3 tasks")
    assert sweep._bar._description.endswith("waiting: scan 1, map 1")
    assert "remaining" in sweep._bar.remaining()
    sweep.advance(outcome("map", ok=False))
    sweep.begin({"map": 5}, 0, 2, "")  # what followed from the first tasks
    assert sweep._bar._total == 5
    sweep.end()
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "3 tasks to run, 4 results stored, 2 workers"
    assert lines[1] == "failed: map of blob: no luck"


@pytest.mark.parametrize(("seconds", "said"), [(5, "0:05"), (125, "2:05"), (3725, "1:02:05")])
def test_clocks(seconds, said):
    assert clock(seconds) == said

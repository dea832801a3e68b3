"""Notes of attempts that are damaged count as none."""

import subprocess
import sys
from pathlib import Path

import pytest

from evaluation.experiment.tasks import Task
from evaluation.running.attempts import Attempt

DAMAGED = ["", "{", "[]", "3", "{}", '{"run": "r"}', '{"run": "r", "attempt": "two"}', "[" * 100_000]
TASK = Task("scan-1", "scan", {}, {}, "walk")


def noted(folder, content):
    (folder / "running").mkdir()
    (folder / "running" / "scan-1.json").write_text(content)


@pytest.mark.parametrize("content", DAMAGED)
def test_a_damaged_note_is_none(tmp_path, content):
    noted(tmp_path, content)
    assert Attempt(tmp_path, TASK, "r", 1.0).lost() is None


def test_a_whole_note_is_read(tmp_path):
    noted(tmp_path, '{"run": "r", "attempt": 1, "pid": 7}')
    found = Attempt(tmp_path, TASK, "r", 1.0).lost()
    assert found is not None
    assert found[0] == "again"


STOPS_THE_WATCHDOG = """
import faulthandler, sys, time
from evaluation.running import attempts
from tests.evaluation.running.test_attempts import TASK

attempts.LATER = 0.2
from pathlib import Path
with attempts.Attempt(Path(sys.argv[1]), TASK, "r", 0.2):
    faulthandler.cancel_dump_traceback_later()
    time.sleep(60)
"""


def test_a_task_that_stops_the_watchdog_is_ended_by_the_second_one(tmp_path):
    root = Path(__file__).resolve().parents[3]
    command = [sys.executable, "-c", STOPS_THE_WATCHDOG, str(tmp_path)]
    ended = subprocess.run(command, cwd=root, timeout=50)
    assert ended.returncode == 1
    kind, reason, detail = Attempt(tmp_path, TASK, "r", 0.2).lost()
    assert (kind, reason.partition(";")[0]) == ("timeout", "no result after 0.2 s")
    assert "has stopped the watchdog" in detail
    assert "<string>" in detail  # where it was

"""Notes of attempts that are damaged count as none."""

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

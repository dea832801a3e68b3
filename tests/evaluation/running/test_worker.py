import logging
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from datasets_gen import InputError
from evaluation.experiment.make_plan import shape_tasks
from evaluation.experiment.tasks import Task
from evaluation.results.store import ResultsStore
from evaluation.running import worker
from evaluation.running.worker import _RecentValues, run_task, stage_of


@pytest.fixture
def shape_task(small):
    return next(iter(shape_tasks(small()).values()))


def test_a_task_is_stored_with_what_it_took(tmp_path, shape_task):
    report = run_task(str(tmp_path), shape_task, "run", 60)
    assert report.ok
    record = ResultsStore(tmp_path).record("shape", shape_task.key)
    assert record["info"]["poses"] == ["bent", "curled", "rest"]
    assert record["spec"] == shape_task.spec
    assert record["versions"]["numpy"] == np.__version__
    assert record["versions"]["python"]
    assert not list((tmp_path / "running").iterdir())


def test_what_a_task_warns_of_is_in_its_outcome(tmp_path, monkeypatch, shape_task):
    real = worker._compute

    def warning(*arguments):
        logging.getLogger("datasets_gen.checks").warning("a hole")
        return real(*arguments)

    monkeypatch.setattr(worker, "_compute", warning)
    assert ("datasets_gen.checks", "a hole") in run_task(str(tmp_path), shape_task, "run", 60).warnings


def test_seconds_are_those_of_the_clock_and_of_the_processor(tmp_path, monkeypatch, shape_task):
    real = worker._compute

    def slowed(*arguments):
        time.sleep(0.3)
        until = time.process_time() + 0.2
        while time.process_time() < until:
            pass
        return real(*arguments)

    monkeypatch.setattr(worker, "_compute", slowed)
    before = time.perf_counter()
    report = run_task(str(tmp_path), shape_task, "run", 60)
    passed = time.perf_counter() - before
    record = ResultsStore(tmp_path).record("shape", shape_task.key)
    assert 0.5 <= record["seconds"] <= passed
    assert record["seconds"] == report.seconds
    assert 0.2 <= record["cpu_seconds"] <= record["seconds"] - 0.25


def test_a_task_that_fails_says_why_and_leaves_no_result(tmp_path, shape_task):
    bad = Task.of("shape", {"name": str(tmp_path / "none"), "options": {}}, {}, "none")
    report = run_task(str(tmp_path), bad, "run", 60)
    assert (report.ok, report.kind) == (False, "error")
    assert "none" in report.reason
    assert "\n" not in report.reason
    assert ResultsStore(tmp_path).record("shape", bad.key) is None
    assert (tmp_path / "failures" / f"{bad.key}.json").is_file()


def test_a_later_success_clears_the_failure(tmp_path, shape_task):
    failure = tmp_path / "failures" / f"{shape_task.key}.json"
    failure.parent.mkdir()
    failure.write_text("{}")
    assert run_task(str(tmp_path), shape_task, "run", 60).ok
    assert not failure.exists()


def attempted(folder, task, run, attempt, dump=""):
    (folder / "running").mkdir(exist_ok=True)
    (folder / "running" / f"{task.key}.json").write_text(
        f'{{"run": "{run}", "attempt": {attempt}, "pid": 1}}'
    )
    (folder / "running" / f"{task.key}.txt").write_text(dump)


def test_what_took_workers_down_is_not_tried_for_ever(tmp_path, shape_task):
    attempted(tmp_path, shape_task, "this", 2)
    report = run_task(str(tmp_path), shape_task, "this", 60)
    assert (report.kind, report.reason[:28]) == ("crash", "took its worker down 2 times")
    assert run_task(str(tmp_path), shape_task, "this", 60).ok  # the note is cleared with the report


def test_one_lost_attempt_may_have_been_bad_luck_and_is_followed_by_one_alone(tmp_path, shape_task):
    attempted(tmp_path, shape_task, "this", 1)
    report = run_task(str(tmp_path), shape_task, "this", 60)
    assert (report.ok, report.kind) == (False, "again")
    assert not (tmp_path / "failures").exists()
    assert run_task(str(tmp_path), shape_task, "this", 60, alone=True).ok


def test_a_fault_is_named(tmp_path, shape_task):
    attempted(tmp_path, shape_task, "this", 2, "Fatal Python error: Segmentation fault\n\nThread ...")
    report = run_task(str(tmp_path), shape_task, "this", 60, alone=True)
    assert (report.kind, "Segmentation fault" in report.reason) == ("crash", True)


def test_tasks_of_one_process_take_turns(tmp_path, monkeypatch, shape_task):
    running, most = [], []

    def compute(*_):
        running.append(1)
        most.append(len(running))
        time.sleep(0.05)
        running.pop()
        raise ValueError("done")

    monkeypatch.setattr(worker, "_compute", compute)
    threads = [
        threading.Thread(target=run_task, args=(str(tmp_path), shape_task, "run", 60)) for _ in range(4)
    ]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert most == [1, 1, 1, 1]


@pytest.mark.parametrize("kind", [SystemExit, GeneratorExit, MemoryError, RecursionError])
def test_whatever_a_task_raises_is_its_own_failure(tmp_path, monkeypatch, shape_task, kind):
    def compute(*_):
        raise kind

    monkeypatch.setattr(worker, "_compute", compute)
    report = run_task(str(tmp_path), shape_task, "run", 60)
    assert (report.kind, report.reason.partition(":")[0]) == ("error", kind.__name__)


def test_an_interrupt_in_a_worker_s_thread_is_the_task_s_and_one_from_the_keyboard_is_not(
    tmp_path, monkeypatch, shape_task
):
    def compute(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(worker, "_compute", compute)
    with ThreadPoolExecutor(1) as pool:
        report = pool.submit(run_task, str(tmp_path), shape_task, "run", 60).result()
    assert (report.kind, report.reason) == ("error", "KeyboardInterrupt")
    with pytest.raises(KeyboardInterrupt):
        run_task(str(tmp_path), shape_task, "run", 60)


def test_recent_values_are_read_only():
    found = _RecentValues(2).get("a", lambda: {"points": np.zeros((2, 3))})
    with pytest.raises(ValueError, match="read-only"):
        found["points"][0] = 1


def test_a_time_out_counts_at_once(tmp_path, shape_task):
    attempted(tmp_path, shape_task, "this", 1, "Timeout (0:00:05)!\nThread ...")
    report = run_task(str(tmp_path), shape_task, "this", 5)
    assert (report.kind, report.reason[:21]) == ("timeout", "no result after 5 s; ")


def test_attempts_of_earlier_runs_do_not_count(tmp_path, shape_task):
    attempted(tmp_path, shape_task, "earlier", 2, "Timeout")
    assert run_task(str(tmp_path), shape_task, "this", 60).ok


def test_a_disk_that_is_full_is_reported(tmp_path, shape_task, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("evaluation.results.store.write_json", full)
    report = run_task(str(tmp_path), shape_task, "run", 60)
    assert (report.ok, report.reason) == (False, "OSError: [Errno 28] No space left on device")


def test_roles_name_their_stage():
    roles = ("shape", "render", "map", "source_scan", "scan", "reference_medial", "source_heat", "operator")
    stages = ["shape", "render", "map", "scan", "scan", "operator", "operator", "operator"]
    assert [stage_of(role) for role in roles] == stages


def test_recent_values_are_kept_and_old_ones_let_go():
    recent, made = _RecentValues(2), []

    def make(name):
        made.append(name)
        return name

    for name in "abac":
        recent.get(name, lambda name=name: make(name))
    assert made == ["a", "b", "c"]
    recent.get("b", lambda: make("b"))
    assert made == ["a", "b", "c", "b"]


def test_an_input_that_vanished_is_named(tmp_path):
    render = Task.of("render", {"pose": "rest", "scanner": {}, "seed": 0}, {"shape": "gone"}, "lost")
    report = run_task(str(tmp_path), render, "run", 60)
    assert "gone" in report.reason
    with pytest.raises(InputError):
        ResultsStore(tmp_path).score("none")


def test_the_watchdog_is_off_afterwards(tmp_path, monkeypatch, shape_task):
    def compute(*_):
        raise ValueError("at once")

    monkeypatch.setattr(worker, "_compute", compute)
    assert run_task(str(tmp_path), shape_task, "run", 1).reason == "ValueError: at once"
    time.sleep(1.2)  # would end this process

"""Methods that misbehave: each is blamed for what it did, and nobody else is."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from evaluation import run
from evaluation.running import execute
from evaluation.running.attempts import Attempt
from evaluation.running.progress import Silent

ROOT = Path(__file__).resolve().parents[3]
PAIR = {"stability": None, "matching": {"sweep": {"threshold": [0.2]}, "pairs": [["rest", "bent"]]}}

RAISED = {
    "exit": "SystemExit: 3",
    "interrupt": "KeyboardInterrupt",
    "memory": "MemoryError: out of memory",
    "recursion": "RecursionError: maximum recursion depth",
    "mute": "Mute: (it cannot say why)",
    "garbled": "ValueError: half [31m of it xxx",
    "write": "ValueError: assignment destination is read-only",
}
ENDED = {"die": "killed, out of memory or an exit", "leave": "or an exit", "fault": "Segmentation fault"}


def methods(method_file, troubles):
    return [{"name": f"{method_file}:Nearest", "label": each, "trouble": each} for each in troubles]


def fine(method_file, count=1):
    return [{"name": f"{method_file}:Nearest", "label": f"fine {i}"} for i in range(count)]


def of_maps(failures):
    """Kind and reason by label of the method."""
    maps = failures[failures.stage == "map"]
    return {
        label.split()[-1]: (kind, reason) for label, kind, reason in maps[["label", "kind", "reason"]].values
    }


@pytest.mark.slow
def test_whatever_a_method_raises_is_noted_and_the_next_method_is_not_harmed(small, tmp_path, method_file):
    kept = run(small(method=fine(method_file), **PAIR), tmp_path / "alone", jobs=1).table()
    quiet = ["note", "base", "settings"]
    chosen = [*methods(method_file, [*RAISED, *quiet]), *fine(method_file)]
    store = run(
        small(method=chosen, **PAIR), tmp_path / "results", jobs=1
    )  # one worker: they share its memory
    found = of_maps(store.failures())
    assert set(found) == set(RAISED)
    for trouble, reason in RAISED.items():
        assert found[trouble][0] == "error"
        assert found[trouble][1].startswith(reason)
        assert len(found[trouble][1]) <= 500
    table = store.table()
    assert set(table.method) == {"fine 0", *quiet}
    measured = ["geodesic_mean", "geodesic_median", "pck_auc", "medial_mean"]
    pd.testing.assert_frame_equal(
        table[table.method == "fine 0"][measured].reset_index(drop=True), kept[measured]
    )


@pytest.mark.slow
def test_a_process_that_ends_is_blamed_on_the_task_that_ran_in_it_alone(small, tmp_path, method_file):
    """Each of six maps ends its worker, with the others waiting at it."""
    killers = [
        {"name": f"{method_file}:Nearest", "label": f"{trouble}-{i}", "trouble": trouble}
        for trouble in ENDED
        for i in range(2)
    ]
    run(small(method=fine(method_file), **PAIR), tmp_path / "results", jobs=1)  # all but the maps
    chosen = [
        each
        for i, killer in enumerate(killers)
        for each in (killer, {**fine(method_file)[0], "label": f"fine {i}", "options": {"number": i}})
    ]
    store = run(small(method=chosen, **PAIR), tmp_path / "results", jobs=2)
    found = of_maps(store.failures())
    assert set(found) == {each["label"] for each in killers}
    for label, (kind, reason) in found.items():
        assert kind == "crash"
        assert reason.startswith("took its worker down 2 times")
        assert ENDED[label.split("-")[0]] in reason
    assert sorted(store.table().method) == [f"fine {i}" for i in range(len(killers))]


class Future:
    def __init__(self, key, outcome):
        self.key, self._outcome, self.released = key, outcome, False

    def add_done_callback(self, call):
        call(self)

    def result(self, timeout):
        return self._outcome()

    def release(self):
        self.released = True


class Client:
    """Runs at once what is submitted; notes which tasks came alone."""

    def __init__(self):
        self.calls, self.futures = [], []

    def nthreads(self):
        return {"here": 2}

    def submit(self, runner, *args, key, pure):
        if args[-1]:  # alone: no outcome is left with a worker that may end
            assert all(each.released for each in self.futures)
        self.calls.append((args[1].key, args[-1]))
        future = Future(key, lambda: runner(*args))
        self.futures.append(future)
        return future


def executed(tasks, runner):
    client = Client()
    cluster = execute.Cluster(client, 2, "", 1.0)
    found = execute.execute(cluster, Path(), tasks, (), run="r", limit=1, progress=Silent(), runner=runner)
    return found, client.calls


def task(name, **inputs):
    return execute.Task(name, "scan", {}, inputs, name)


def test_failures_are_there_though_the_run_ends_early():
    """A run whose workers are all gone wrote an empty list of failures."""

    def runner(folder, task, run, limit, alone):
        if task.key == "b":
            raise execute.CancelledError
        return execute.Outcome(task, False, "it fails", "error")

    client, failures = Client(), []
    cluster = execute.Cluster(client, 1, "", 1.0)
    with pytest.raises(execute.InputError, match="the scheduler is gone"):
        execute.execute(
            cluster, Path(), [task("a"), task("b")], (), run="r", limit=1, progress=Silent(),
            runner=runner, failures=failures,
        )  # fmt: skip
    assert [(each.task.key, each.reason) for each in failures] == [("a", "it fails")]


def test_suspects_are_tried_last_and_alone_and_what_needs_them_follows():
    def runner(folder, task, run, limit, alone):
        kind = "again" if task.key in "ac" and not alone else ""
        return execute.Outcome(task, not kind, kind and "its worker ended", kind)

    tasks = [task("a"), task("b"), task("c"), task("d", x="a"), task("e", x="b")]
    failures, calls = executed(tasks, runner)
    assert failures == []
    assert calls[:4] == [("a", False), ("b", False), ("c", False), ("e", False)]
    assert calls[4:] == [("a", True), ("d", False), ("c", True)]


def test_what_dask_gives_up_on_is_tried_alone_before_it_is_blamed():
    def runner(folder, task, run, limit, alone):
        if task.key == "bad" or not alone:
            raise RuntimeError("killed\nworker")
        return execute.Outcome(task, True)

    failures, calls = executed([task("good"), task("bad")], runner)
    assert [(each.task.key, each.kind, each.reason) for each in failures] == [
        ("bad", "crash", "RuntimeError: killed worker")
    ]
    assert calls == [("good", False), ("bad", False), ("good", True), ("bad", True)]


def test_what_was_tried_alone_and_given_up_is_blamed_with_its_fault(tmp_path):
    (tmp_path / "running").mkdir()
    (tmp_path / "running" / "bad.json").write_text('{"run": "r", "attempt": 1, "pid": 1}')
    (tmp_path / "running" / "bad.txt").write_text("Fatal Python error: Segmentation fault\nmore")
    attempt = Attempt(tmp_path, task("bad"), "r", 1.0, alone=True)
    reason = attempt.given_up()
    assert reason == "took its worker down 2 times (Fatal Python error: Segmentation fault)"
    assert attempt.given_up() is None  # told once
    assert list((tmp_path / "running").iterdir()) == []


def test_a_scheduler_that_is_gone_ends_the_run_with_one_line():
    def runner(*_):
        raise execute.CancelledError("lost connection")

    with pytest.raises(execute.InputError, match=r"the scheduler is gone .*; results are stored"):
        executed([task("a")], runner)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "killpg"), reason="no process groups here")
def test_ctrl_c_says_one_line(small, tmp_path, method_file):
    """Of the command; sent to all of its processes, as a terminal does."""
    settings, folder = tmp_path / "hang.toml", tmp_path / "results"
    settings.write_text(small(**PAIR, method=methods(method_file, ["hang"])).to_toml())
    command = [
        sys.executable,
        "-m",
        "reports.cli.main",
        "run",
        str(settings),
        "-o",
        str(folder),
        "-j",
        "2",
        "-q",
    ]
    process = subprocess.Popen(
        command, cwd=ROOT, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True
    )
    deadline = time.monotonic() + 120
    while not list(folder.glob("running/*hang*.json")) and process.poll() is None:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)
    out, said = process.communicate(timeout=60)
    assert out == ""
    assert (
        said == f"medialbench: interrupted; results so far are in {str(folder)!r}, the same command goes on\n"
    )
    assert process.returncode == 130

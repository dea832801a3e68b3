"""The processes of a sweep killed, stopped, interrupted or lost, at seeded moments; then it goes on."""

import contextlib
import json
import os
import random
import re
import signal
import sys
from functools import partial

import pytest

from tests.faults.sweep import (
    TASKS,
    check_finished,
    check_whole,
    ended,
    experiment,
    results,
    run_here,
    started,
    wait_for,
)

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are found by /proc")
SEEDS = [
    pytest.param(seed, marks=[pytest.mark.slow, pytest.mark.long] if seed else [], id=f"seed {seed}")
    for seed in range(3)
]


def workers(process):
    """Processes of the workers of a sweep."""
    found = []
    for entry in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError):  # it has ended
            if os.getpgid(int(entry)) == process.pid:
                with open(f"/proc/{entry}/cmdline", "rb") as stream:
                    found += [int(entry)] * (b"spawn_main" in stream.read())
    return found


def has(folder, count):
    """Whether so many results are stored."""
    return results(folder) >= count


def running(folder):
    """Processes that have begun a task."""
    found = []
    for note in (folder / "running").glob("[!.]*.json"):
        with contextlib.suppress(OSError, ValueError):  # the task has ended
            found.append(json.loads(note.read_text())["pid"])
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_the_driver_killed(seed, settings, undisturbed, tmp_path, monkeypatch, injected):
    """Again and again, until a few results are left to do."""
    rng, folder = random.Random(seed), tmp_path / "results"
    reached = rng.randint(1, 9)
    while reached < (TASKS if seed else 10):
        process = started(settings[1], folder, seconds=0.05)
        if wait_for(partial(has, folder, reached), process):
            os.kill(process.pid, signal.SIGKILL)
            injected("driver killed")
        ended(process)
        assert has(folder, reached)
        reached += rng.randint(9, 12)
    assert results(folder) < TASKS
    run_here(settings[0], folder, monkeypatch)
    check_finished(folder, undisturbed)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_workers_killed(seed, settings, undisturbed, tmp_path, injected):
    """While they compute: what ran in them is tried again alone, and nothing is blamed."""
    rng, folder = random.Random(seed), tmp_path / "results"
    process = started(settings[1], folder, 2, seconds=0.1)
    for reached in sorted(rng.sample(range(1, TASKS - 4), 2)):
        if wait_for(partial(has, folder, reached), process):
            for pid in running(folder)[:1]:
                with contextlib.suppress(ProcessLookupError):  # the note of one that was killed before
                    os.kill(pid, signal.SIGKILL)
                    injected("worker killed")
    assert ended(process) == ("", 0)
    check_finished(folder, undisturbed)


@pytest.mark.parametrize("seed", SEEDS)
def test_ctrl_c(seed, settings, undisturbed, tmp_path, monkeypatch, injected):
    """One line and exit code 130, whenever it comes; sent to all processes, as a terminal does."""
    # half of the tasks are left, so that a slow machine is not done before the signal comes
    folder, at = tmp_path / "results", random.Random(seed).randint(1, TASKS // 2)
    process = started(settings[1], folder, 2, seconds=0.1)
    moment = [partial(has, folder, at), partial(workers, process), partial(running, folder)][seed % 3]
    assert wait_for(moment, process)
    os.killpg(process.pid, signal.SIGINT)
    said, status = ended(process)
    assert re.fullmatch(r"medialbench: interrupted; results so far are in .* goes on\n", said)
    assert status == 130
    injected("SIGINT")
    check_whole(folder)
    run_here(settings[0], folder, monkeypatch)
    check_finished(folder, undisturbed)


class Interrupts:
    """Progress that is interrupted after so many tasks."""

    def __init__(self, tasks):
        self.tasks = tasks

    def begin(self, waiting, stored, workers, dashboard):
        pass

    def advance(self, outcome):
        self.tasks -= 1
        if not self.tasks:
            raise KeyboardInterrupt

    def end(self):
        pass


def test_the_table_of_an_interrupted_run_is_not_the_last(
    settings, undisturbed, tmp_path, monkeypatch, injected
):
    """A run that was interrupted has merged; one that was killed has stored the rest and merged nothing."""
    folder = tmp_path / "results"
    with pytest.raises(KeyboardInterrupt):
        run_here(settings[0], folder, monkeypatch, progress=Interrupts(TASKS - 3))
    kept = {name: (folder / name).read_bytes() for name in ("run.json", "table.parquet", "table.csv")}
    run_here(settings[0], folder, monkeypatch)
    for name, whole in kept.items():  # as if killed after the last task
        (folder / name).write_bytes(whole)
    injected("driver killed")
    run_here(settings[0], folder, monkeypatch)
    check_finished(folder, undisturbed)


def test_what_killed_runs_have_left_is_removed(settings, undisturbed, tmp_path, monkeypatch):
    folder = tmp_path / "results"
    for name in (
        "maps/.body-rest-k3j_x0ab.npz",
        ".table-a8b7c6d5.parquet",
        "running/a.json",
        "running/a.txt",
    ):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("half")
    (folder / ".mine").write_text("of somebody else")
    run_here(settings[0], folder, monkeypatch)
    (folder / ".mine").unlink()
    check_finished(folder, undisturbed)


class Leaves(Interrupts):
    """Progress beside which a worker is killed as it writes, or so the folder looks."""

    def __init__(self, path):
        self.path = path

    def advance(self, outcome):
        self.path.parent.mkdir(exist_ok=True)
        self.path.write_text("half")


def test_what_workers_killed_in_this_run_have_left_is_removed(settings, undisturbed, tmp_path, monkeypatch):
    folder = tmp_path / "results"
    path = folder / "maps/.body-rest-k3j_x0ab.npz"
    run_here(settings[0], folder, monkeypatch, progress=Leaves(path))
    check_finished(folder, undisturbed)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(("fault", "count"), [("LOST", 1), ("LOST", 2), ("STUCK", 1)])
def test_workers_lost_as_they_start(fault, count, settings, undisturbed, tmp_path, injected):
    """One or both of two: they are started again."""
    folder, marks = tmp_path / "results", tmp_path / "marks"
    marks.mkdir()
    for number in range(count):
        (marks / str(number)).touch()
    env = {f"MEDIALBENCH_TEST_{fault}": str(marks), "MEDIALBENCH_TEST_START": "30"}
    process = started(settings[1], folder, 2, start=True, env=env)
    assert ended(process) == ("", 0)
    assert not list(marks.iterdir())
    injected(f"worker {fault.lower()} at its start", count)
    check_finished(folder, undisturbed)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.long
def test_a_worker_that_hangs_as_it_starts_again_while_the_sweep_ends(
    settings, undisturbed, tmp_path, injected
):
    folder, marks = tmp_path / "results", tmp_path / "marks"
    marks.mkdir()
    env = {"MEDIALBENCH_TEST_STUCK": str(marks)}
    process = started(settings[1], folder, 2, seconds=0.1, start=True, env=env)
    assert wait_for(partial(has, folder, TASKS - 8), process)
    (marks / "0").touch()
    os.kill(workers(process)[0], signal.SIGKILL)
    assert ended(process) == ("", 0)
    assert not list(marks.iterdir())
    injected("worker stuck at its start")
    check_finished(folder, undisturbed)


@pytest.mark.slow
def test_workers_that_never_start(settings, tmp_path, injected):
    marks = tmp_path / "marks"
    marks.mkdir()
    for number in range(20):
        (marks / str(number)).touch()
    env = {"MEDIALBENCH_TEST_LOST": str(marks)}
    said, status = ended(started(settings[1], tmp_path / "results", 2, start=True, env=env))
    assert re.fullmatch(r"medialbench: the workers on this machine do not start \(.*\); try fewer .*\n", said)
    assert status == 1
    injected("worker lost at its start", 20 - len(list(marks.iterdir())))


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_a_worker_that_is_stopped(seed, tmp_path, injected):
    """Within a task or between two, its watchdog with it: the driver ends it."""
    folder = tmp_path / "results"
    made = experiment(tmp_path / "made", timeout=2.0)
    (tmp_path / "small.toml").write_text(made.to_toml())
    env = {"MEDIALBENCH_TEST_GRACE": "10"}
    process = started(tmp_path / "small.toml", folder, 2, seconds=0.2, env=env)
    assert wait_for(partial(has, folder, random.Random(seed).randint(1, TASKS - 4)), process)
    os.kill(random.Random(seed).choice(workers(process)), signal.SIGSTOP)
    injected("worker stopped")
    assert ended(process) == ("", 0)
    assert results(folder) == TASKS
    check_whole(folder)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_two_at_once(seed, settings, undisturbed, tmp_path, monkeypatch, injected):
    """The second says who has the folder, or finds all done."""
    folder, at = tmp_path / "results", random.Random(seed).randint(0, TASKS)
    first = started(settings[1], folder, seconds=0.1)
    wait_for(lambda: not seed or has(folder, at), first)
    second = started(settings[1], folder, seconds=0.1)
    ends = [ended(first), ended(second)]
    injected("second writer")
    assert 0 in [status for _, status in ends]
    for said, status in ends:
        assert (said, status) == ("", 0) or re.fullmatch(
            rf"medialbench: '{folder}' is in use by (process \d+ on .*|another process); wait, .*\n", said
        )
    check_finished(folder, undisturbed)
    run_here(settings[0], folder, monkeypatch)
    check_finished(folder, undisturbed)

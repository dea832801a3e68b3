"""What a sweep costs besides its tasks."""

import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

from evaluation.experiment.tasks import Task
from evaluation.results.outcome import Outcome
from evaluation.running.cluster import connect
from evaluation.running.execute import execute
from evaluation.running.progress import Silent
from tests.evaluation.conftest import blobs, method_file, small  # noqa: F401  (fixtures)


def say(benchmark, **figures):
    """Note figures in the record and show them; `make perf` runs with -s."""
    benchmark.extra_info.update(figures)
    sys.stdout.write("\n" + benchmark.name + ": " + ", ".join(f"{k} {v}" for k, v in figures.items()) + "\n")


MANY = int(os.environ.get("MEDIALBENCH_MANY", "20000"))
"""Trivial tasks of the memory test; 100000 takes some minutes."""


def trivial(folder, task, run, limit):
    """A task that does nothing, with a result as large as a real report."""
    return Outcome(task, True, seconds=0.0, detail="x" * 1000)


def spin(folder, task, run, limit):
    """A task that keeps a processor busy for a tenth of a second of its own time."""
    start = time.process_time()
    while time.process_time() - start < 0.1:
        pass
    return Outcome(task, True, seconds=0.1)


def chain(n, width=50):
    """Tasks of which each needs the one `width` before it."""
    for i in range(n):
        yield Task(
            f"t{i}", "scan", {"number": i}, {"scan": f"t{i - width}"} if i >= width else {}, f"task {i}"
        )


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with connect(tmp_path_factory.mktemp("cluster"), 2, None) as found:
        yield found


def run_all(cluster, tasks, runner, name):
    failures = execute(cluster, Path("."), tasks, (), run=name, limit=60, progress=Silent(), runner=runner)
    assert not failures


def test_overhead_per_task(benchmark, cluster):
    """Seconds per 500 trivial tasks; the goal is below 25 (50 ms a task)."""
    count = iter(range(10**6))
    benchmark.pedantic(
        lambda: run_all(cluster, list(chain(500)), trivial, f"o{next(count)}"), rounds=3, warmup_rounds=1
    )
    say(benchmark, milliseconds_per_task=round(1000 * benchmark.stats["median"] / 500, 1))
    assert benchmark.stats["median"] / 500 < 0.05


def test_both_workers_are_busy(benchmark, cluster):
    """200 tasks of 0.1 s: busy time over wall time and workers; the goal is 0.85 (on an idle machine)."""
    count = iter(range(10**6))
    tasks = list(chain(200))
    benchmark.pedantic(lambda: run_all(cluster, tasks, spin, f"b{next(count)}"), rounds=1)
    busy = 200 * 0.1 / cluster.workers / benchmark.stats["median"]
    say(benchmark, percent_of_the_time_busy=round(100 * busy, 1))


@dataclass
class Memory(Silent):
    """Progress that notes this process's memory now and then, in MB."""

    every: int
    ended: int = 0

    def __post_init__(self):
        self.seen = []

    def advance(self, report):
        self.ended += 1
        if self.ended % self.every == 0:
            pages = int(Path("/proc/self/statm").read_text().split()[1])
            self.seen.append(pages * os.sysconf("SC_PAGE_SIZE") / 2**20)


def test_memory_does_not_grow_with_results(benchmark, cluster):
    """Memory of the process that plans, schedules and collects, from a quarter of the tasks to the end."""
    tasks, memory = list(chain(MANY)), Memory(every=MANY // 20)
    benchmark.pedantic(
        lambda: execute(cluster, Path("."), tasks, (), run="m", limit=60, progress=memory, runner=trivial),
        rounds=1,
    )
    say(benchmark, tasks=MANY, megabytes=[round(m) for m in memory.seen[:: len(memory.seen) // 5]])
    grown = (memory.seen[-1] - memory.seen[4]) * 2**20 / (0.75 * MANY)
    assert grown < 1000  # bytes per task: keeping the reports would take more than that


def test_a_repeated_command(benchmark, small, tmp_path):  # noqa: F811
    """A finished experiment asked for again; the goal is below 3 s, imports included elsewhere."""
    from evaluation import run

    experiment = small()
    run(experiment, tmp_path / "results", jobs=2)
    benchmark.pedantic(lambda: run(experiment, tmp_path / "results"), rounds=5, warmup_rounds=1)
    assert benchmark.stats["median"] < 3

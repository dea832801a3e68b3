"""Runs tasks on a Dask cluster: in the order their inputs come in, a few at a time, whatever fails."""

import heapq
import logging
from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from datasets_gen.records import InputError
from evaluation.running.cluster import Cluster
from evaluation.running.progress import Progress
from evaluation.running.tasks import Report, Task
from evaluation.running.worker import run_task

log = logging.getLogger(__name__)

LOOK_EVERY = 5.0
"""Seconds between looks for workers while no task ends."""

IN_FLIGHT = 3
"""Tasks handed to the scheduler per worker: enough that none waits, few enough that memory stays flat."""

Runner = Callable[[str, Task, str, float], Report]


class Queue:
    """Tasks whose inputs are there, the earliest planned first; and what follows when one ends.

    Parameters
    ----------
    tasks
        To be run, inputs before the tasks that need them.
    stored
        Keys of results that are there already.
    """

    def __init__(self, tasks: Collection[Task], stored: Collection[str]) -> None:
        self._tasks = list(tasks)
        number = {task.key: i for i, task in enumerate(self._tasks)}
        self._missing = [0] * len(self._tasks)
        self._followers: dict[str, list[int]] = defaultdict(list)
        self._number = number
        self._ready: list[int] = []
        self._ended: set[str] = set()
        for i, task in enumerate(self._tasks):
            for key in dict.fromkeys(task.inputs.values()):
                if key in number:
                    self._missing[i] += 1
                    self._followers[key].append(i)
                elif key not in stored:
                    raise ValueError(f"task {task.key!r} needs {key!r}, which is neither stored nor planned")
            if not self._missing[i]:
                self._ready.append(i)
        heapq.heapify(self._ready)

    def pop(self) -> Task | None:
        """The next task that can run; None if all wait for others."""
        return self._tasks[heapq.heappop(self._ready)] if self._ready else None

    def succeeded(self, task: Task) -> None:
        """Free the tasks that waited for this one alone."""
        self._ended.add(task.key)
        for i in self._followers.pop(task.key, ()):
            self._missing[i] -= 1
            if not self._missing[i] and self._tasks[i].key not in self._ended:
                heapq.heappush(self._ready, i)

    def failed(self, task: Task) -> Iterator[Task]:
        """Give up on what needs this task; yields those tasks, each once."""
        self._ended.add(task.key)
        waiting = list(self._followers.pop(task.key, ()))
        while waiting:
            follower = self._tasks[waiting.pop(0)]
            if follower.key not in self._ended:
                self._ended.add(follower.key)
                waiting.extend(self._followers.pop(follower.key, ()))
                yield follower


def execute(
    cluster: Cluster,
    folder: Path,
    tasks: Collection[Task],
    stored: Collection[str],
    *,
    run: str,
    limit: float,
    progress: Progress,
    runner: Runner = run_task,
) -> list[Report]:
    """Run tasks; returns the reports of those that have no result.

    Parameters
    ----------
    cluster
    folder
        The results folder.
    tasks
        Inputs before the tasks that need them.
    stored
        Keys of results that are there already.
    run
        Name of the run.
    limit
        Seconds per task.
    progress
        Told of every task that ends.
    runner
        What a worker calls; `run_task` but for tests.
    """
    queue = Queue(tasks, stored)
    failures: list[Report] = []
    flying: dict[Any, Task] = {}
    done: SimpleQueue[Any] = SimpleQueue()

    def submit() -> None:
        while len(flying) < IN_FLIGHT * max(cluster.workers, 1):
            task = queue.pop()
            if task is None:
                return
            key = (
                f"{task.stage}-{run}",
                task.key,
            )  # grouped by stage: the scheduler remembers groups for ever
            future = cluster.client.submit(runner, str(folder), task, run, limit, key=key, pure=False)
            flying[future.key] = task
            future.add_done_callback(done.put)

    submit()
    while flying:
        future = _next(done, cluster)
        task = flying.pop(future.key)
        for each in _settle(queue, _report(task, future)):
            failures.extend([] if each.ok else [each])
            progress.advance(each)
        submit()
    return failures


def _next(done: "SimpleQueue[Any]", cluster: Cluster) -> Any:
    """The next future that has ended; gives up if there has been no worker for too long."""
    alone = 0.0
    while True:
        try:
            return done.get(timeout=LOOK_EVERY)
        except Empty:
            alone = 0.0 if cluster.client.nthreads() else alone + LOOK_EVERY
            if alone >= cluster.patience:
                raise InputError(
                    f"no worker for {alone:.0f} s: all are gone; results are stored, the same command goes on"
                ) from None


def _report(task: Task, future: Any) -> Report:
    """What a worker reported, or what Dask says of a task whose worker never answered."""
    try:
        found = future.result()
    except Exception as error:
        return Report(task, False, f"{type(error).__name__}: {error}".splitlines()[0], "crash")
    return found if isinstance(found, Report) else Report(task, False, f"no report but {found!r}", "crash")


def _settle(queue: Queue, report: Report) -> Iterator[Report]:
    """The report itself, and one for every task that cannot run because of it."""
    yield report
    if report.ok:
        queue.succeeded(report.task)
        return
    log.info("failed: %s: %s", report.task.label, report.reason)
    for follower in queue.failed(report.task):
        reason = f"not run because of {report.task.label!r} ({report.task.stage}): {report.reason}"
        yield Report(follower, False, reason, "blocked")


def by_stage(tasks: Collection[Task]) -> Mapping[str, int]:
    """Number of tasks of each stage."""
    counts: dict[str, int] = defaultdict(int)
    for task in tasks:
        counts[task.stage] += 1
    return dict(counts)

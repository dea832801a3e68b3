"""Runs tasks on a Dask cluster: in the order their inputs come in, a few at a time, whatever fails."""

import logging
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from datasets_gen.records import InputError
from evaluation.experiment.tasks import Task
from evaluation.results.outcome import Outcome
from evaluation.running.cluster import Cluster
from evaluation.running.progress import ProgressCallbacks
from evaluation.running.task_queue import TaskQueue
from evaluation.running.worker import run_task

log = logging.getLogger(__name__)

LOOK_EVERY = 5.0
"""Seconds between looks for workers while no task ends."""

IN_FLIGHT = 3
"""Tasks handed to the scheduler per worker: enough that none waits, few enough that memory stays flat."""

Runner = Callable[[str, Task, str, float], Outcome]


def execute(
    cluster: Cluster,
    folder: Path,
    tasks: Collection[Task],
    stored: Collection[str],
    *,
    run: str,
    limit: float,
    progress: ProgressCallbacks,
    runner: Runner = run_task,
) -> list[Outcome]:
    """Run tasks; returns the outcomes of those that have no result.

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
    queue = TaskQueue(tasks, stored)
    failures: list[Outcome] = []
    flying: dict[Any, Task] = {}
    done: SimpleQueue[Any] = SimpleQueue()

    def submit() -> None:
        while len(flying) < IN_FLIGHT * max(cluster.workers, 1):
            task = queue.pop()
            if task is None:
                return
            key = (f"{task.stage}-{run}", task.key)  # by stage: the scheduler remembers groups for ever
            future = cluster.client.submit(runner, str(folder), task, run, limit, key=key, pure=False)
            flying[future.key] = task
            future.add_done_callback(done.put)

    submit()
    while flying:
        future = _next(done, cluster)
        task = flying.pop(future.key)
        for each in _settle(queue, _outcome(task, future)):
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


def _outcome(task: Task, future: Any) -> Outcome:
    """What a worker reported, or what Dask says of a task whose worker never answered."""
    try:
        found = future.result()
    except Exception as error:
        return Outcome(task, False, f"{type(error).__name__}: {error}".splitlines()[0], "crash")
    return found if isinstance(found, Outcome) else Outcome(task, False, f"no outcome but {found!r}", "crash")


def _settle(queue: TaskQueue, outcome: Outcome) -> Iterator[Outcome]:
    """The outcome itself, and one for every task that cannot run because of it."""
    yield outcome
    if outcome.ok:
        queue.succeeded(outcome.task)
        return
    log.info("failed: %s: %s", outcome.task.label, outcome.reason)
    for follower in queue.failed(outcome.task):
        reason = f"not run because of {outcome.task.label!r} ({outcome.task.stage}): {outcome.reason}"
        yield Outcome(follower, False, reason, "blocked")

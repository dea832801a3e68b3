"""Runs tasks on a Dask cluster: in the order their inputs come in, a few at a time, whatever fails."""

import contextlib
import logging
from collections import deque
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import CancelledError
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from datasets_gen.records import InputError
from evaluation.experiment.tasks import Task
from evaluation.results.outcome import Outcome, one_line
from evaluation.running.attempts import AGAIN, Attempt
from evaluation.running.cluster import Cluster
from evaluation.running.process import polled_interrupts
from evaluation.running.progress import ProgressCallbacks
from evaluation.running.task_queue import TaskQueue
from evaluation.running.task_warnings import repeat_warnings
from evaluation.running.worker import run_task
from evaluation.running.worker_watch import LOOK_EVERY, WorkerWatch

log = logging.getLogger(__name__)

IN_FLIGHT = 3
"""Tasks handed to the scheduler per worker: enough that none waits, few enough that memory stays flat."""

Runner = Callable[[str, Task, str, float, bool], Outcome]


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
    failures: list[Outcome] | None = None,
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
    failures
        What is returned, filled as tasks fail: it is there even if the run is interrupted.
    """
    queue = TaskQueue(tasks, stored)
    failures = [] if failures is None else failures
    flying: dict[Any, tuple[Task, bool]] = {}
    suspects: deque[Task] = deque()  # their worker ended: to be tried when nothing else runs
    done: SimpleQueue[Any] = SimpleQueue()

    def submit(task: Task, alone: bool) -> None:
        key = (f"{task.stage}-{run}", task.key + alone * "-alone")  # the scheduler remembers groups for ever
        future = cluster.client.submit(runner, str(folder), task, run, limit, alone, key=key, pure=False)
        flying[future.key] = task, alone
        future.add_done_callback(done.put)

    def submit_what_can_run() -> None:
        while len(flying) < IN_FLIGHT * max(cluster.workers, 1) and (task := queue.pop()) is not None:
            submit(task, False)
        if suspects and not flying:
            submit(suspects.popleft(), True)

    watch = WorkerWatch(cluster, limit)
    with polled_interrupts(lambda: done.put(None)) as check_interrupt:

        def look() -> None:
            check_interrupt()
            watch.look()

        submit_what_can_run()
        while flying:
            future = _next(done, look)
            task, alone = flying.pop(future.key)
            outcome = _outcome(Attempt(folder, task, run, limit, alone), task, future, look, alone)
            repeat_warnings(outcome)
            future.release()  # or Dask runs it again if the worker that holds the outcome ends
            if outcome.kind == AGAIN:
                suspects.append(task)
            else:
                for each in _settle(queue, outcome):
                    failures.extend([] if each.ok else [each])
                    progress.advance(each)
            submit_what_can_run()
    return failures


def _next(done: "SimpleQueue[Any]", look: Callable[[], None]) -> Any:
    """The next future that has ended, with looks at the workers and at Ctrl-C meanwhile."""
    while True:
        look()
        with contextlib.suppress(Empty):
            if (future := done.get(timeout=LOOK_EVERY)) is not None:  # it is None when Ctrl-C ends the wait
                return future


def _outcome(attempt: Attempt, task: Task, future: Any, look: Callable[[], None], alone: bool) -> Outcome:
    """What a worker reported, or what Dask says of a task whose worker never answered.

    Dask gives up on a task that was waiting at several workers when others took them down: it is innocent
    until that happens when it is alone.
    """
    try:
        found = _result(future, look)
    except CancelledError as error:
        raise InputError(
            f"the scheduler is gone ({one_line(error)}); results are stored, the same command goes on"
        ) from error
    except Exception as error:
        reason = (attempt.given_up() if alone else None) or one_line(error)
        return Outcome(task, False, reason, "crash" if alone else AGAIN)
    return found if isinstance(found, Outcome) else Outcome(task, False, f"no outcome but {found!r}", "crash")


def _result(future: Any, look: Callable[[], None]) -> Any:
    """What a task returned; the worker that holds it may hang, and runs it again when it was replaced."""
    while True:
        try:
            return future.result(timeout=LOOK_EVERY)
        except TimeoutError:
            if future.status == "error":  # it is what the task raised
                raise
            look()


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

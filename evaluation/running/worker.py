"""Runs one task: in a worker of a Dask cluster, or right here.

Everything goes through the results folder, so a task may run anywhere that sees it.
"""

import contextlib
import threading
import time
import traceback
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from datasets_gen.records import InputError
from evaluation.experiment.tasks import STAGES, Task
from evaluation.results.outcome import Outcome, one_line
from evaluation.results.store import ResultsStore
from evaluation.running.attempts import AGAIN, Attempt
from evaluation.running.process import forget_safe_path, keep_freed_memory, peak_memory, single_thread
from evaluation.running.read_only import read_only
from evaluation.running.stages.interface import Inputs
from evaluation.running.task_warnings import gathered_warnings

SETTLED = 1.0
"""Seconds of a process before it computes anything: Dask never replaces one that ends while it starts."""
_BORN = time.monotonic()
CACHED = 12
"""Records a worker keeps, most recently used: neighbouring tasks share inputs."""

ROLE_STAGES = {"shape": "shape", "render": "render", "map": "map"}
"""Stage of an input by its role; ``*scan`` are scans and the others operators."""


def run_task(folder: str, task: Task, run: str, limit: float, alone: bool = False) -> Outcome:
    """Compute and store one task; one at a time per process, so that a lost process is blamed on that one.

    Parameters
    ----------
    folder
        The results folder.
    task
    run
        Name of the run: attempts of earlier runs do not count.
    limit
        Seconds after which this process is ended.
    alone
        Whether no other task of the run is in flight.

    Returns
    -------
    Outcome
        Never raises for what a task does, be it that it asks the interpreter to exit. Of kind
        `evaluation.running.attempts.AGAIN`, with nothing computed, if the task has to be tried alone.
    """
    with _ONE_AT_A_TIME, gathered_warnings() as said:
        outcome = _run(ResultsStore(folder), task, Attempt(Path(folder), task, run, limit, alone))
    return replace(outcome, warnings=tuple(said))


_ONE_AT_A_TIME = threading.Lock()


def _run(store: ResultsStore, task: Task, attempt: Attempt) -> Outcome:
    keep_freed_memory()
    forget_safe_path()
    lost = attempt.lost()
    if lost:
        kind, reason, detail = lost
        if kind == AGAIN:
            return Outcome(task, False, reason, kind)
        return _failed(store, task, kind, reason, detail)
    start, used = time.perf_counter(), time.process_time()
    try:
        with attempt, single_thread(), peak_memory() as memory:
            info = _compute(store, task)
        seconds, used = time.perf_counter() - start, time.process_time() - used
        store.write_record(task, seconds, used, memory.megabytes, info)
    except InputError as error:
        return _failed(store, task, "error", str(error), start=start)
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt) and threading.current_thread() is threading.main_thread():
            raise  # from the keyboard; in a worker, tasks run in another thread, which no signal reaches
        return _failed(store, task, "error", one_line(error), traceback.format_exc(), start)
    return Outcome(task, True, seconds=seconds)


def _failed(
    store: ResultsStore, task: Task, kind: str, reason: str, detail: str = "", start: float | None = None
) -> Outcome:
    seconds = 0.0 if start is None else time.perf_counter() - start
    outcome = Outcome(task, False, reason, kind, seconds, detail)
    with contextlib.suppress(
        InputError, OSError
    ):  # a full disk must not hide the reason: the driver has it too
        store.write_failure(outcome)
    return outcome


def _compute(store: ResultsStore, task: Task) -> Mapping[str, Any]:
    """Compute a task and store its record; returns its info."""
    stage = import_module(STAGES[task.stage])
    keys = task.inputs

    def load(role: str) -> Any:
        return _CACHE.get((str(store.folder), keys[role]), lambda: _load(store, stage_of(role), keys[role]))

    def note(role: str) -> Mapping[str, Any]:
        record = store.record(stage_of(role), keys[role])
        if record is None:
            raise InputError(f"input {keys[role]!r} is missing from {str(store.folder)!r}; run again")
        return dict(record["info"])

    def derive(role: str, function: Callable[[Any], Any]) -> Any:
        return _CACHE.get(
            (str(store.folder), keys[role], function.__qualname__), lambda: function(load(role))
        )

    time.sleep(max(0.0, _BORN + SETTLED - time.monotonic()))  # next to nothing: importing took as long
    output = stage.compute(task.spec, Inputs(keys, load, note, derive))
    if output.save is not None:
        output.save(store.path(task.stage, task.key))
    return dict(output.info)


def stage_of(role: str) -> str:
    """Stage whose result plays a role."""
    return ROLE_STAGES.get(role, "scan" if role.endswith("scan") else "operator")


def _load(store: ResultsStore, stage: str, key: str) -> Any:
    if stage == "shape":
        return store.shape(key)
    if stage == "operator":
        return store.operator(key)
    if stage == "map":
        return store.matching(key)
    from scanner_sim import Scan

    return Scan.load(store.whole_path(stage, key))


class _RecentValues:
    """The last few values, by name; read-only, as they are shared."""

    def __init__(self, size: int) -> None:
        self._size, self._values = size, OrderedDict[Any, Any]()

    def get(self, name: Any, make: Callable[[], Any]) -> Any:
        if name not in self._values:
            self._values[name] = read_only(make())
        self._values.move_to_end(name)
        while len(self._values) > self._size:
            self._values.popitem(last=False)
        return self._values[name]


_CACHE = _RecentValues(CACHED)

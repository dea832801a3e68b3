"""Runs one task: in a worker of a Dask cluster, or right here.

Everything goes through the results folder, so a task may run anywhere that sees it.
"""

import contextlib
import time
import traceback
from collections import OrderedDict
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from datasets_gen.collection import Collection
from datasets_gen.records import InputError
from evaluation.experiment.tasks import STAGES, Task
from evaluation.results.outcome import Outcome
from evaluation.results.store import ResultsStore
from evaluation.running.attempts import Attempt
from evaluation.running.process import keep_freed_memory, peak_memory, single_thread
from evaluation.running.stages.interface import Inputs

CACHED = 12
"""Records a worker keeps, most recently used: neighbouring tasks share inputs."""

ROLE_STAGES = {"shape": "shape", "render": "render", "map": "map"}
"""Stage of an input by its role; ``*scan`` are scans and the others operators."""


def run_task(folder: str, task: Task, run: str, limit: float) -> Outcome:
    """Compute and store one task.

    Parameters
    ----------
    folder
        The results folder.
    task
    run
        Name of the run: attempts of earlier runs do not count.
    limit
        Seconds after which this process is ended.

    Returns
    -------
    Outcome
        Never raises for what a task does.
    """
    keep_freed_memory()
    store = ResultsStore(folder)
    attempt = Attempt(Path(folder), task, run, limit)
    lost = attempt.lost()
    if lost:
        return _failed(store, task, *lost)
    start, used = time.perf_counter(), time.process_time()
    try:
        with attempt, single_thread(), peak_memory() as memory:
            info = _compute(store, task)
        seconds, used = time.perf_counter() - start, time.process_time() - used
        store.write_record(task, seconds, used, memory.megabytes, info)
    except InputError as error:
        return _failed(store, task, "error", str(error), start=start)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        return _failed(store, task, "error", reason, traceback.format_exc(), start)
    return Outcome(task, True, seconds=seconds)


def _failed(
    store: ResultsStore, task: Task, kind: str, reason: str, detail: str = "", start: float | None = None
) -> Outcome:
    seconds = 0.0 if start is None else time.perf_counter() - start
    outcome = Outcome(task, False, " ".join(reason.split()), kind, seconds, detail)
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

    output = stage.compute(task.spec, Inputs(keys, load, note, derive))
    if output.save is not None:
        output.save(store.path(task.stage, task.key))
    return dict(output.info)


def stage_of(role: str) -> str:
    """Stage whose result plays a role."""
    return ROLE_STAGES.get(role, "scan" if role.endswith("scan") else "operator")


def _load(store: ResultsStore, stage: str, key: str) -> Any:
    if stage == "shape":
        return Collection.load(store.path(stage, key))
    if stage == "operator":
        return store.operator(key)
    if stage == "map":
        return store.matching(key)
    from scanner_sim import Scan

    return Scan.load(store.path(stage, key))


class _RecentValues:
    """The last few values, by name."""

    def __init__(self, size: int) -> None:
        self._size, self._values = size, OrderedDict[Any, Any]()

    def get(self, name: Any, make: Callable[[], Any]) -> Any:
        if name not in self._values:
            self._values[name] = make()
        self._values.move_to_end(name)
        while len(self._values) > self._size:
            self._values.popitem(last=False)
        return self._values[name]


_CACHE = _RecentValues(CACHED)

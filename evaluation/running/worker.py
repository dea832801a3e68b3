"""Runs one task: in a worker of a Dask cluster, or right here.

Everything goes through the results folder, so a task may run anywhere that sees it. A task that never
comes back is dealt with too: before it starts, an attempt is noted; a watchdog that needs no interpreter
lock ends the process at the time limit; whoever gets the task next finds the note and reports instead of
trying for ever.
"""

import contextlib
import ctypes
import faulthandler
import functools
import json
import os
import time
import traceback
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from datasets_gen.records import InputError
from evaluation.results.collection_file import load_collection
from evaluation.results.store import ResultsStore, write_json
from evaluation.running.stages.interface import Inputs
from evaluation.running.tasks import STAGES, Report, Task

ATTEMPTS = 2
"""Times that a task may take its process down before it counts as failed; a time-out counts at once."""

CACHED = 8
"""Records a worker keeps, most recently used: neighbouring tasks share inputs."""

ROLE_STAGES = {"shape": "shape", "render": "render", "map": "map"}
"""Stage of an input by its role; ``*scan`` are scans and the others operators."""


def run_task(folder: str, task: Task, run: str, limit: float) -> Report:
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
    Report
        Never raises for what a task does.
    """
    keep_freed_memory()
    store = ResultsStore(folder)
    attempt = _Attempt(Path(folder), task, run, limit)
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
    return Report(task, True, seconds=seconds)


def _failed(
    store: ResultsStore, task: Task, kind: str, reason: str, detail: str = "", start: float | None = None
) -> Report:
    seconds = 0.0 if start is None else time.perf_counter() - start
    report = Report(task, False, " ".join(reason.split()), kind, seconds, detail)
    with contextlib.suppress(
        InputError, OSError
    ):  # a full disk must not hide the reason: the driver has it too
        store.write_failure(report)
    return report


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
        return load_collection(store.path(stage, key))
    if stage == "operator":
        return store.operator(key)
    if stage == "map":
        return store.matching(key)
    from scanner_sim import Scan

    return Scan.load(store.path(stage, key))


class _Recent:
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


_CACHE = _Recent(CACHED)


class _Attempt:
    """Notes that a task was started here, so that its disappearance is noticed."""

    def __init__(self, folder: Path, task: Task, run: str, limit: float) -> None:
        self._note = folder / "running" / f"{task.key}.json"
        self._dump = folder / "running" / f"{task.key}.txt"
        self._run, self._limit, self._count = run, limit, 0

    def lost(self) -> tuple[str, str, str] | None:
        """Kind, reason and detail if earlier attempts of this run took their process down for good."""
        try:
            note = json.loads(self._note.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        if note.get("run") != self._run:
            return None
        self._count = int(note["attempt"])
        dump = self._dump.read_text(encoding="utf-8") if self._dump.is_file() else ""
        if dump.startswith("Timeout"):
            self.clear()
            return (
                "timeout",
                f"no result after {self._limit:g} s; raise 'timeout' or look at the detail",
                dump,
            )
        if self._count >= ATTEMPTS:
            self.clear()
            return (
                "crash",
                f"took its worker down {self._count} times (killed, out of memory or a fault)",
                dump,
            )
        return None

    def __enter__(self) -> None:
        write_json(self._note, {"run": self._run, "attempt": self._count + 1, "pid": os.getpid()})
        self._stream = self._dump.open("w", encoding="utf-8")
        faulthandler.dump_traceback_later(self._limit, exit=True, file=self._stream)

    def __exit__(self, *_: object) -> None:
        faulthandler.cancel_dump_traceback_later()
        self._stream.close()
        self.clear()

    def clear(self) -> None:
        self._note.unlink(missing_ok=True)
        self._dump.unlink(missing_ok=True)


@contextlib.contextmanager
def single_thread() -> Iterator[None]:
    """One thread for BLAS and OpenMP: tasks run side by side, and results must not depend on how many."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield


@functools.cache
def keep_freed_memory() -> None:
    """Let the allocator keep what is freed: Dask's nanny asks it to give back everything at once.

    With Dask's setting (``MALLOC_TRIM_THRESHOLD_=65536``) a match spent a third of its time in page faults.
    Nothing happens where the C library is not glibc.
    """
    trim_threshold, mmap_threshold = -1, -3  # names of malloc.h
    with contextlib.suppress(OSError, AttributeError, TypeError):
        mallopt = ctypes.CDLL(None).mallopt
        mallopt(trim_threshold, 512 << 20)
        mallopt(mmap_threshold, 32 << 20)


class PeakMemory:
    """Filled when the block of `peak_memory` ends."""

    megabytes: float | None = None


@contextlib.contextmanager
def peak_memory() -> Iterator[PeakMemory]:
    """Largest resident memory of this process within a block, where the system can tell (Linux)."""
    found = PeakMemory()
    try:
        Path("/proc/self/clear_refs").write_text("5")  # resets the high-water mark
        resets = True
    except OSError:
        resets = False
    yield found
    if resets:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                found.megabytes = int(line.split()[1]) / 1024

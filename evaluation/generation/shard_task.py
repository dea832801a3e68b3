"""Makes one shard, or one reference mesh: in a worker of a Dask cluster, or right here."""

import json
import shutil
import tarfile
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from datasets_gen import Collection, load
from datasets_gen.parsing import parsed_json
from datasets_gen.records import InputError, atomic_path
from evaluation.experiment.tasks import Task
from evaluation.generation.generated_folder import GeneratedFolder
from evaluation.generation.generation_config import GenerationConfig
from evaluation.generation.sample_making import FailedSample, samples_of
from evaluation.generation.sample_plan import SamplePlan
from evaluation.results.outcome import Outcome, one_line
from evaluation.running.attempts import Attempt
from evaluation.running.process import forget_safe_path, keep_freed_memory, single_thread
from evaluation.running.task_warnings import gathered_warnings

BYTES_PER_POINT = 72
"""Of all arrays of a sample."""
BYTES_PER_SAMPLE = 16_000
"""Headers, padding and the JSON file."""
MOST_LOADED = 8
"""Data sets that a worker keeps."""


def make_file(folder: str, task: Task, run: str, limit: float, alone: bool = False) -> Outcome:
    """Make the file of a task; one at a time per process.

    Parameters
    ----------
    folder
        Of the training data.
    task
        Of stage ``"shard"`` or ``"reference"``.
    run, limit, alone
        As for `evaluation.running.worker.run_task`.

    Returns
    -------
    Outcome
        Never raises for what a task does.
    """
    with _ONE_AT_A_TIME, gathered_warnings() as said:
        outcome = _make(GeneratedFolder(Path(folder)), task, Attempt(Path(folder), task, run, limit, alone))
    return replace(outcome, warnings=tuple(said))


_ONE_AT_A_TIME = threading.Lock()


def _make(folder: GeneratedFolder, task: Task, attempt: Attempt) -> Outcome:
    keep_freed_memory()
    forget_safe_path()
    lost = attempt.lost()
    if lost:
        kind, reason, detail = lost
        return Outcome(task, False, reason, kind, detail=detail)
    start = time.perf_counter()
    try:
        with attempt, single_thread():
            facts = (
                _write_reference(folder, task) if task.stage == "reference" else _write_shard(folder, task)
            )
        folder.write_note(task, {"seconds": time.perf_counter() - start, **facts})
    except InputError as error:
        return Outcome(task, False, str(error), "error", time.perf_counter() - start)
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt) and threading.current_thread() is threading.main_thread():
            raise  # from the keyboard; in a worker, tasks run in another thread, which no signal reaches
        seconds, detail = time.perf_counter() - start, traceback.format_exc()
        return Outcome(task, False, one_line(error), "error", seconds, detail)
    return Outcome(task, True, seconds=time.perf_counter() - start)


def _write_reference(folder: GeneratedFolder, task: Task) -> dict[str, Any]:
    plan = _plan(task)
    collection = _collection(plan, task.spec["dataset"])
    collection.reference.save(folder.file_of(task))
    rest = collection.reference
    return {"vertices": len(rest.vertices), "faces": len(rest.faces), "remarks": list(collection.remarks)}


def _write_shard(folder: GeneratedFolder, task: Task) -> dict[str, Any]:
    """Samples go into the file as they are made, so that memory stays flat; it is renamed when complete."""
    plan, path = _plan(task), folder.file_of(task)
    load_set = _loader(plan)
    split, first, count = task.spec["split"], task.spec["first"], task.spec["count"]
    check_space(path.parent, sample_bytes(plan.config) * count)
    rows: list[dict[str, Any]] = []
    failed: list[FailedSample] = []
    with atomic_path(path) as temporary, tarfile.open(temporary, "w", format=tarfile.USTAR_FORMAT) as archive:
        for made in samples_of(plan, split, first, count, load_set):
            if isinstance(made, FailedSample):
                failed.append(made)
            else:
                made.write(archive)
                rows.append(_row(made.about))
    return {
        "split": split,
        "samples": rows,
        "failures": [
            {
                "key": each.identity.key,
                "dataset": each.identity.dataset,
                "pose": each.identity.pose,
                "reason": each.reason,
            }
            for each in failed
        ],
        "again": not all(each.refused for each in failed),
    }


def _row(about: Mapping[str, Any]) -> dict[str, Any]:
    """What the table of all samples says of one."""
    views = about["views"]
    names = ("key", "dataset", "individual", "pose", "held_out", "seed", "threshold", "points", "missing")
    return {name: about[name] for name in names} | {
        "views": views if isinstance(views, str | int) else len(views)
    }


def sample_bytes(config: GenerationConfig) -> int:
    """Most bytes of a sample in a shard."""
    swept = config.draw.sweep.get("points", ())
    return BYTES_PER_POINT * max(config.scan.points, *swept, 0) + BYTES_PER_SAMPLE


def check_space(folder: Path, needed: int) -> None:
    """Raise InputError if a file system has less space than a shard may need; nothing is computed in vain."""
    try:
        free = shutil.disk_usage(folder).free
    except OSError:  # a system that does not tell
        return
    if free < needed:
        raise InputError(
            f"cannot write to {str(folder)!r}: {free / 1e6:.0f} MB are free, a shard needs up to "
            f"{needed / 1e6:.0f} MB; free some space, the same command goes on"
        )


@lru_cache(maxsize=2)
def _plan_of(text: str) -> SamplePlan:
    tables = parsed_json(text, "task")
    return SamplePlan(GenerationConfig.from_table(tables["settings"]), tables["known"])


def _plan(task: Task) -> SamplePlan:
    tables = {name: task.spec[name] for name in ("settings", "known")}
    return _plan_of(json.dumps(tables, sort_keys=True))


def _loader(plan: SamplePlan) -> Callable[[str], Collection]:
    """Loads data sets by name; one that cannot be loaded is not tried again for every sample of a shard."""
    broken: dict[str, InputError] = {}

    def load_set(name: str) -> Collection:
        if name in broken:
            raise broken[name]
        try:
            return _collection(plan, name)
        except InputError as error:
            broken[name] = error
            raise

    return load_set


def _collection(plan: SamplePlan, name: str) -> Collection:
    section = plan.set_named(name).section
    return _loaded(section.name, json.dumps(dict(section.options), sort_keys=True))


@lru_cache(maxsize=MOST_LOADED)
def _loaded(name: str, options: str) -> Collection:
    return load(name, **parsed_json(options, "options"))

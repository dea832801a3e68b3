"""One call from a configuration to a folder of training data."""

import contextlib
import logging
import os
import time
import uuid
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from datasets_gen.records import InputError, atomic_path
from evaluation.experiment.tasks import Task
from evaluation.generation.datasheet import write_summary
from evaluation.generation.generated_folder import GeneratedFolder
from evaluation.generation.generation_config import GenerationConfig
from evaluation.generation.generation_plan import GenerationPlan, check_folder_kept, make_generation_plan
from evaluation.generation.shard_task import make_file, sample_bytes
from evaluation.results.folder_lock import lock_folder
from evaluation.results.integrity import damage_line
from evaluation.results.outcome import Outcome
from evaluation.running.cluster import Cluster, connect
from evaluation.running.environment import usable_processors
from evaluation.running.execute import execute
from evaluation.running.progress import TYPICAL, ProgressCallbacks, Silent
from evaluation.running.tls import TlsFiles

log = logging.getLogger(__name__)

SHARD_SIZE = 100
"""Samples per shard, unless another number is asked for."""
START = 600.0
"""Seconds that a task may take beside its samples: building the bodies, the first time."""
TYPICAL_SAMPLE = 0.3
"""Seconds per sample."""


@dataclass(frozen=True)
class GenerationResult:
    """What a call of `generate` left.

    Attributes
    ----------
    folder : Path
    samples : int
        In the folder.
    planned : int
    made : int
        In this call.
    seconds : float
        Of this call.
    failures : tuple of str
        A line for each sample or file that is missing.
    """

    folder: Path
    samples: int
    planned: int
    made: int
    seconds: float
    failures: tuple[str, ...]


def generate(
    config: GenerationConfig | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    samples: int,
    *,
    shard_size: int = SHARD_SIZE,
    jobs: int | None = None,
    scheduler: str | None = None,
    tls: TlsFiles | None = None,
    dashboard: bool = False,
    force: bool = False,
    progress: ProgressCallbacks | None = None,
) -> GenerationResult:
    """Make scans with ground truth in shards; shards that are there and whole are not made again.

    Parameters
    ----------
    config
        A `GenerationConfig`, the name of a preset or the path of a TOML file.
    folder
        Where the shards go; the same folder goes on where an interrupted call stopped, and is extended by a
        larger number of samples.
    samples
        Of both splits together.
    shard_size
        Samples per shard.
    jobs, scheduler, tls, dashboard, progress
        As for `evaluation.run`.
    force
        Remove what was generated in the folder before.

    Returns
    -------
    GenerationResult

    Raises
    ------
    InputError
        If the configuration cannot be used, the folder holds other samples, cannot be written or is in use,
        the scheduler cannot be reached, or no data set can be loaded.
    """
    settings = config if isinstance(config, GenerationConfig) else GenerationConfig.load(config)
    place = GeneratedFolder(Path(folder).resolve())
    plan = make_generation_plan(settings, samples, shard_size)
    if not force:
        check_folder_kept(place, plan)
    with lock_folder(place.path), contextlib.ExitStack() as stack:
        place.remove_leftovers()
        if force:
            place.clear()
        place.write_state(plan.state)
        run = _Generation(place, plan, progress or Silent())
        try:
            run.complete(lambda: stack.enter_context(connect(place.path, jobs, scheduler, tls, dashboard)))
        except BaseException:  # interrupted: what there is has a datasheet, too
            with contextlib.suppress(InputError, OSError):
                run.finished()
            raise
        finally:
            run.progress.end()
        result = run.finished()
    return result


class _Generation:
    """One call, from what is there to the datasheet."""

    def __init__(self, folder: GeneratedFolder, plan: GenerationPlan, progress: ProgressCallbacks) -> None:
        self.folder, self.plan, self.progress = folder, plan, progress
        self.failures: list[Outcome] = []
        self.made: list[Task] = []
        self.started = time.monotonic()
        self.name = uuid.uuid4().hex[:8]

    def complete(self, opened: Callable[[], Cluster]) -> None:
        """Make what is not there."""
        stored, damaged = self.folder.examined(self.plan.tasks)
        if damaged:
            log.warning("%s", damage_line(damaged))
        references = [task for task in self.plan.references if task.key not in stored]
        shards = [task for task in self.plan.shards if task.key not in stored]
        if not references and not shards:
            return
        cluster = opened()
        waiting = {"reference": len(references), "shard": len(shards)}
        self.progress.begin(
            {stage: count for stage, count in waiting.items() if count},
            len(stored),
            cluster.workers,
            cluster.dashboard,
        )
        self._run(cluster, references)  # first, so that each body is built once and comes from the cache then
        if references and len(self.failures) == len(self.plan.references):
            raise InputError(f"no data set can be loaded; the first: {self.failures[0].reason}")
        self._run(cluster, shards)

    def _run(self, cluster: Cluster, tasks: Sequence[Task]) -> None:
        counts = [task.spec.get("count", 1) for task in tasks]
        execute(
            cluster,
            self.folder.path,
            tasks,
            (),
            run=self.name,
            limit=START + self.plan.config.timeout * max(counts, default=0),
            progress=self.progress,
            runner=make_file,
            failures=self.failures,
        )
        failed = {each.task.key for each in self.failures}
        self.made += [task for task in tasks if task.key not in failed]

    def finished(self) -> GenerationResult:
        """Write what describes the folder, also if there is only a part of it."""
        with atomic_path(self.folder.path / "generation.toml") as temporary:
            temporary.write_text(self.plan.config.to_toml(), encoding="utf-8")
        with contextlib.suppress(OSError):
            (self.folder.path / "running").rmdir()  # of the notes of attempts; empty
        seconds = time.monotonic() - self.started
        notes = write_summary(self.folder, self.plan, self.failures)
        made = {str(task.spec["file"]) for task in self.made}
        lines = [f"{each.task.label}: {each.reason}" for each in self.failures]
        lines += [
            f"{each['key']} ({each['dataset']}, {each['pose']}): {each['reason']}"
            for note in notes
            for each in note["failures"]
        ]
        return GenerationResult(
            folder=self.folder.path,
            samples=sum(len(note["samples"]) for note in notes),
            planned=sum(self.plan.counts.values()),
            made=sum(len(note["samples"]) for note in notes if note["file"] in made),
            seconds=seconds,
            failures=tuple(lines),
        )


@dataclass(frozen=True)
class GenerationOutlook:
    """What a call of `generate` would do.

    Attributes
    ----------
    plan : GenerationPlan
    stored, waiting : int
        Shards that are there and whole, and the others.
    megabytes : float
        Most that all shards take.
    seconds : float
        Rough estimate for what is waiting.
    workers : int
        Worker processes that this estimate is for.
    """

    plan: GenerationPlan
    stored: int
    waiting: int
    megabytes: float
    seconds: float
    workers: int


def preview_generation(
    config: GenerationConfig | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    samples: int,
    *,
    shard_size: int = SHARD_SIZE,
    jobs: int | None = None,
    force: bool = False,
) -> GenerationOutlook:
    """What `generate` would do: no body is built, nothing is written; arguments and errors as there."""
    settings = config if isinstance(config, GenerationConfig) else GenerationConfig.load(config)
    place, plan = GeneratedFolder(Path(folder).resolve()), make_generation_plan(settings, samples, shard_size)
    stored: set[str] = set()
    if not force:
        check_folder_kept(place, plan)
        stored, _ = place.examined(plan.tasks)
    waiting = [task for task in plan.shards if task.key not in stored]
    bodies = sum(task.key not in stored for task in plan.references)
    workers = jobs or usable_processors()
    left = sum(task.spec["count"] for task in waiting)
    return GenerationOutlook(
        plan=plan,
        stored=len(plan.shards) - len(waiting),
        waiting=len(waiting),
        megabytes=sample_bytes(settings) * samples / 1e6,
        seconds=(left * TYPICAL_SAMPLE + bodies * TYPICAL["shape"]) / workers,
        workers=workers,
    )

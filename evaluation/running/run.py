"""One call from an experiment to a results folder."""

import contextlib
import os
import platform
import time
import uuid
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from datasets_gen.fingerprints import digest
from datasets_gen.records import atomic_path
from evaluation.experiment.experiment import Experiment
from evaluation.experiment.plan import Plan, make_plan, shape_tasks
from evaluation.experiment.toml import dumps
from evaluation.results.store import FORMAT, ResultsStore, write_json
from evaluation.results.table import merge
from evaluation.running.cluster import Cluster, connect
from evaluation.running.locking import lock
from evaluation.running.progress import Progress, Silent
from evaluation.running.sweep import by_stage, execute
from evaluation.running.tasks import Report, Task

LIBRARIES = (
    "medialbench",
    "numpy",
    "scipy",
    "numba",
    "mitsuba",
    "drjit",
    "robust-laplacian",
    "dask",
    "pandas",
)


@dataclass
class Outlook:
    """What a run would do, or did.

    Attributes
    ----------
    waiting : Mapping
        Tasks to run by stage.
    stored : int
        Results that are there already.
    rows : int
        Rows of the finished table.
    unavailable : Mapping
        Labels of methods that cannot run here, and why.
    unknown : tuple of str
        Data sets whose poses are known only once they have been made: their tasks are not counted.
    """

    waiting: Mapping[str, int]
    stored: int
    rows: int
    unavailable: Mapping[str, str] = field(default_factory=dict)
    unknown: tuple[str, ...] = ()


def run(
    experiment: Experiment | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    *,
    jobs: int | None = None,
    scheduler: str | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> ResultsStore:
    """Run an experiment; what is stored already is not run again.

    Parameters
    ----------
    experiment
        An `Experiment`, the name of a preset or the path of a TOML file.
    folder
        Where results go; the same folder goes on where an interrupted run stopped.
    jobs
        Worker processes, one thread each; the number of usable processors if not given.
    scheduler
        Address of a Dask scheduler to use instead.
    force
        Run everything again.
    progress
        Told what happens; `evaluation.running.progress.Bars` draws it.

    Returns
    -------
    ResultsStore
        Its `failures` lists what could not be done; a sweep does not stop at failures.

    Raises
    ------
    InputError
        If the experiment cannot be used, the folder cannot be written or is in use, or the scheduler
        cannot be reached.
    """
    settings = experiment if isinstance(experiment, Experiment) else Experiment.load(experiment)
    path = Path(folder).resolve()
    store = ResultsStore(path)
    make_plan(settings, shape_tasks(settings), {})  # names and options are wrong before anything is written
    with lock(path):
        sweep = _Sweep(settings, store, jobs, scheduler, force, progress or Silent())
        return sweep.run()


def preview(experiment: Experiment | str | os.PathLike[str], folder: str | os.PathLike[str]) -> Outlook:
    """What `run` would do, without doing it: nothing is written.

    Raises
    ------
    InputError
        If the experiment cannot be used.
    """
    settings = experiment if isinstance(experiment, Experiment) else Experiment.load(experiment)
    store = ResultsStore(Path(folder).resolve())
    shapes = shape_tasks(settings)
    records = {name: store.record("shape", task.key) for name, task in shapes.items()}
    known = {name: dict(record["info"]) for name, record in records.items() if record is not None}
    unknown = tuple(name for name in shapes if name not in known)
    plan = make_plan(settings, shapes, known)
    waiting = [task for task in plan.tasks.values() if store.record(task.stage, task.key) is None]
    return Outlook(
        by_stage(waiting), len(plan.tasks) - len(waiting), len(plan.rows), plan.unavailable, unknown
    )


class _Sweep:
    """One run, from lock to table."""

    def __init__(
        self,
        experiment: Experiment,
        store: ResultsStore,
        jobs: int | None,
        scheduler: str | None,
        force: bool,
        progress: Progress,
    ) -> None:
        self.experiment, self.store, self.force, self.progress = experiment, store, force, progress
        self.jobs, self.scheduler = jobs, scheduler
        self.name = uuid.uuid4().hex[:8]
        self.started = time.time()
        self.fresh: set[str] = set()
        self.failures: list[Report] = []
        self.ran = 0
        self._stack = contextlib.ExitStack()
        self._cluster: Cluster | None = None

    def run(self) -> ResultsStore:
        shapes = shape_tasks(self.experiment)
        plan = Plan({task.key: task for task in shapes.values()})
        with self._stack:
            try:
                self._complete(plan)
                known = {}
                for name, task in shapes.items():
                    record = self.store.record("shape", task.key)
                    if record is not None:
                        known[name] = record["info"]
                plan = make_plan(self.experiment, shapes, known)
                self._complete(plan)
            except BaseException:
                if self._cluster is not None:  # interrupted: what there is makes a table too
                    self._finish(plan, shapes)
                raise
            finally:
                self.progress.end()
            self._finish(plan, shapes)
        return self.store

    def _complete(self, plan: Plan) -> None:
        """Run what has no result yet."""
        failed = {report.task.key for report in self.failures}
        waiting, stored = [], set()
        for task in plan.tasks.values():
            again = self.force and task.key not in self.fresh
            if not again and self.store.record(task.stage, task.key) is not None:
                stored.add(task.key)
            elif task.key not in failed:
                waiting.append(task)
        if not waiting:
            return
        cluster = self._connected()
        self.progress.begin(by_stage(waiting), len(stored), cluster.workers, cluster.dashboard)
        failures = execute(
            cluster,
            self.store.folder,
            waiting,
            stored,
            run=self.name,
            limit=self.experiment.timeout,
            progress=self.progress,
        )
        self.failures.extend(failures)
        self.fresh.update({task.key for task in waiting} - {report.task.key for report in failures})
        self.ran += len(waiting) - sum(report.kind == "blocked" for report in failures)

    def _connected(self) -> Cluster:
        if self._cluster is None:
            self._cluster = self._stack.enter_context(connect(self.store.folder, self.jobs, self.scheduler))
            self._write_experiment()
        return self._cluster

    def _write_experiment(self) -> None:
        with atomic_path(self.store.folder / "experiment.toml") as temporary:
            temporary.write_text(dumps(self.experiment.as_dict()), encoding="utf-8")

    def _finish(self, plan: Plan, shapes: Mapping[str, Task]) -> None:
        """Merge the table unless it is merged already, and note what made it."""
        for label, reason in plan.unavailable.items():
            self.failures.append(Report(Task(label, "map", {}, {}, label), False, reason, "unavailable"))
        state = digest([[dict(row.columns), row.score] for row in plan.rows])
        before = self.store.run_info()
        unchanged = self.ran == 0 and before.get("rows_digest") == state and not self.failures
        if unchanged and (self.store.folder / "table.parquet").is_file() and not before.get("failures"):
            return
        self._write_experiment()
        table = merge(self.store, plan, self.failures)
        info = {
            "format": FORMAT,
            "experiment": self.experiment.name,
            "config_hash": digest(self.experiment.as_dict())[:16],
            "seeds": list(self.experiment.seeds),
            "datasets": {name: task.key for name, task in shapes.items()},
            "rows": len(table),
            "rows_planned": len(plan.rows),
            "rows_digest": state,
            "tasks_run": self.ran,
            "failures": len(self.failures),
            "wall_seconds": time.time() - self.started,
            "finished": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
            "workers": self._cluster.workers if self._cluster else 0,
            "versions": _versions(),
            "mitsuba_variants": self._variants(plan),
            "machine": _machine(),
        }
        write_json(self.store.folder / "run.json", info)

    def _variants(self, plan: Plan) -> list[str]:
        """Mitsuba variants that traced the scans."""
        renders = (
            self.store.record("render", task.key) for task in plan.tasks.values() if task.stage == "render"
        )
        return sorted({record["info"]["variant"] for record in renders if record is not None})


def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for name in LIBRARIES:
        with contextlib.suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def _machine() -> dict[str, Any]:
    return {
        "node": platform.node(),
        "system": platform.platform(),
        "processor": _processor(),
        "cores": os.cpu_count(),
    }


def _processor() -> str:
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()

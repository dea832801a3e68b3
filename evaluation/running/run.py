"""One call from an experiment to a results folder."""

import contextlib
import logging
import os
import time
import uuid
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from datasets_gen.fingerprints import digest
from datasets_gen.records import InputError, atomic_path
from datasets_gen.registry import outline
from evaluation.experiment.experiment import Experiment, portable
from evaluation.experiment.make_plan import make_plan, shape_tasks
from evaluation.experiment.plan import Plan
from evaluation.experiment.tasks import Task
from evaluation.results.folder_lock import lock_folder
from evaluation.results.integrity import damage_line
from evaluation.results.origin import Origin
from evaluation.results.outcome import Outcome
from evaluation.results.store import FORMAT, ResultsStore
from evaluation.results.table import write_tables
from evaluation.running.cluster import Cluster, connect
from evaluation.running.environment import machine, versions
from evaluation.running.execute import execute
from evaluation.running.progress import ProgressCallbacks, Silent
from evaluation.running.task_queue import by_stage
from evaluation.running.tls import TlsFiles

log = logging.getLogger(__name__)


def run(
    experiment: Experiment | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    *,
    jobs: int | None = None,
    scheduler: str | None = None,
    tls: TlsFiles | None = None,
    dashboard: bool = False,
    force: bool = False,
    progress: ProgressCallbacks | None = None,
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
    tls
        Certificates for that scheduler, if its address begins with ``tls://``.
    dashboard
        Whether local workers have Dask's dashboard, which every user of this machine can see.
    force
        Run everything again.
    progress
        Told what happens (`evaluation.running.progress.ProgressCallbacks`); nobody if None.

    Returns
    -------
    ResultsStore
        Its `failures` lists what could not be done; a run does not stop at failures.

    Raises
    ------
    InputError
        If the experiment cannot be used, the folder cannot be written or is in use, or the scheduler
        cannot be reached.
    """
    settings = experiment if isinstance(experiment, Experiment) else Experiment.load(experiment)
    path = Path(folder).resolve()
    store = ResultsStore(path)
    shapes = shape_tasks(settings)
    plan = make_plan(settings, shapes, known_poses(store, shapes))  # raises before anything is written
    with lock_folder(path):
        opened = partial(connect, path, jobs, scheduler, tls, dashboard)
        return _Run(settings, store, opened, force, progress or Silent()).run(plan, shapes)


def known_poses(store: ResultsStore, shapes: Mapping[str, Task]) -> dict[str, Mapping[str, Any]]:
    """Subject, poses and reference of data sets: as stored, else from the registry or the names of the files.

    Parameters
    ----------
    store
    shapes
        Shape tasks by name of the data set (`shape_tasks`).

    Returns
    -------
    dict
        ``subject``, ``poses`` and ``reference`` by name of the data set.

    Raises
    ------
    InputError
        If a data set is unknown, holds no meshes or lacks a pose that is asked for.
    """
    records = {name: store.record("shape", task.key) for name, task in shapes.items()}
    return {
        name: record["info"] if record else outline(shapes[name].spec["name"], **shapes[name].spec["options"])
        for name, record in records.items()
    }


class _Run:
    """One run, from lock to table."""

    def __init__(
        self,
        experiment: Experiment,
        store: ResultsStore,
        opened: Callable[[], contextlib.AbstractContextManager[Cluster]],
        force: bool,
        progress: ProgressCallbacks,
    ) -> None:
        self.experiment, self.store, self.force, self.progress = experiment, store, force, progress
        self._opened = opened
        self.name = uuid.uuid4().hex[:8]
        self.started = time.monotonic()
        self.failures: list[Outcome] = []
        self.ran = 0
        self._stack = contextlib.ExitStack()
        self._cluster: Cluster | None = None

    def run(self, plan: Plan, shapes: Mapping[str, Task]) -> ResultsStore:
        with self._stack:
            try:
                self._complete(plan)
            except BaseException:
                if self._cluster is not None:  # interrupted: what there is makes a table too
                    self._finish_early(plan, shapes)
                raise
            finally:
                self.progress.end()
            self._finish(plan, shapes)
        return self.store

    def _complete(self, plan: Plan) -> None:
        """Run what has no result yet."""
        self.store.remove_leftovers()
        stored, damaged = (set(), {}) if self.force else self.store.examined(plan.tasks.values())
        if damaged:
            log.warning("%s", damage_line(damaged))
        waiting = [task for task in plan.tasks.values() if task.key not in stored]
        if not waiting:
            return
        cluster = self._connected()
        self.progress.begin(by_stage(waiting), len(stored), cluster.workers, cluster.dashboard)
        execute(
            cluster,
            self.store.folder,
            waiting,
            stored,
            run=self.name,
            limit=self.experiment.timeout,
            progress=self.progress,
            failures=self.failures,
        )
        self.store.remove_leftovers()
        self.ran = len(waiting) - sum(outcome.kind == "blocked" for outcome in self.failures)

    def _connected(self) -> Cluster:
        if self._cluster is None:
            self._cluster = self._stack.enter_context(self._opened())
            self._write_experiment()
        return self._cluster

    def _write_experiment(self) -> None:
        with atomic_path(self.store.folder / "experiment.toml") as temporary:
            temporary.write_text(self.experiment.to_toml(), encoding="utf-8")

    def _finish_early(self, plan: Plan, shapes: Mapping[str, Task]) -> None:
        """Merge what there is; if that fails too, what ended the run is what is said."""
        try:
            self._finish(plan, shapes)
        except (InputError, OSError) as error:
            log.info("no table of what there is: %s", error)

    def _finish(self, plan: Plan, shapes: Mapping[str, Task]) -> None:
        """Merge the table unless it is merged already, and note what made it."""
        for label, reason in plan.unavailable.items():
            self.failures.append(Outcome(Task(label, "map", {}, {}, label), False, reason, "unavailable"))
        state = digest([[dict(row.columns), row.score] for row in plan.rows])
        before = self.store.last_run()
        complete = before.get("rows") == len(plan.rows)  # or it was merged when a run was interrupted
        unchanged = self.ran == 0 and complete and before.get("rows_digest") == state and not self.failures
        if unchanged and self.store.is_merged() and not before.get("failures"):
            return
        self._write_experiment()
        origin = Origin.of(self.experiment.name, portable(self.experiment.as_dict()))
        table = write_tables(self.store, plan, self.failures, origin)
        info = {
            "format": FORMAT,
            "experiment": self.experiment.name,
            "config_hash": origin.config_hash,
            "seeds": list(self.experiment.seeds),
            "datasets": {name: task.key for name, task in shapes.items()},
            "rows": len(table),
            "rows_planned": len(plan.rows),
            "rows_digest": state,
            "tasks_run": self.ran,
            "failures": len(self.failures),
            "wall_seconds": time.monotonic() - self.started,
            "finished": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
            "workers": self._cluster.workers if self._cluster else 0,
            "versions": versions(),
            "mitsuba_variants": self._variants(plan),
            "machine": machine(),
        }
        self.store.write_run_info(info)

    def _variants(self, plan: Plan) -> list[str]:
        """Mitsuba variants that traced the scans."""
        renders = (
            self.store.record("render", task.key) for task in plan.tasks.values() if task.stage == "render"
        )
        return sorted({record["info"]["variant"] for record in renders if record is not None})

"""What a run would do, without doing it: tasks by stage, rows, and how long it would take."""

import os
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from evaluation.experiment.experiment import Experiment
from evaluation.experiment.make_plan import make_plan, shape_tasks
from evaluation.experiment.plan import Plan
from evaluation.results.store import ResultsStore
from evaluation.running.environment import usable_processors
from evaluation.running.progress import TYPICAL, seconds_of
from evaluation.running.run import known_poses
from evaluation.running.task_queue import by_stage

TYPICAL_POINTS = 5000
"""Points per cloud that `TYPICAL` belongs to; operators of more take longer in proportion."""


@dataclass(frozen=True)
class Outlook:
    """What a run would do.

    Attributes
    ----------
    waiting : Mapping of str to int
        Tasks to run by stage, those of data sets that are still to be loaded included.
    stored : int
        Results that are there already.
    rows : int
        Rows of the finished table.
    poses : Mapping of str to tuple of str
        Poses that the table is about, by name of the data set.
    seconds : float
        Estimated duration: the number of tasks of each stage times what the stored ones took on average
        (`evaluation.running.progress.TYPICAL` where there are none), over the number of workers.
    workers : int
        Worker processes that this estimate is for.
    unavailable : Mapping of str to str
        Labels of methods that cannot run here, and why.
    """

    waiting: Mapping[str, int]
    stored: int
    rows: int
    poses: Mapping[str, tuple[str, ...]]
    seconds: float
    workers: int
    unavailable: Mapping[str, str] = field(default_factory=dict)


def preview(
    experiment: Experiment | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    *,
    jobs: int | None = None,
) -> Outlook:
    """What `run` would do: no data set is built, nothing is written.

    Poses of data sets that are not stored yet are told from the registry or from the names of the files.

    Parameters
    ----------
    experiment
        An `Experiment`, the name of a preset or the path of a TOML file.
    folder
        The results folder; need not exist.
    jobs
        Worker processes; the number of usable processors if not given.

    Returns
    -------
    Outlook

    Raises
    ------
    InputError
        If the experiment or one of its data sets cannot be used.
    """
    settings = experiment if isinstance(experiment, Experiment) else Experiment.load(experiment)
    store = ResultsStore(Path(folder).resolve())
    shapes = shape_tasks(settings)
    plan = make_plan(settings, shapes, known_poses(store, shapes))
    stored, _ = store.examined(plan.tasks.values())
    records = {
        key: store.record(task.stage, key) if key in stored else None for key, task in plan.tasks.items()
    }
    waiting = by_stage([task for key, task in plan.tasks.items() if records[key] is None])
    workers = jobs or usable_processors()
    seconds = seconds_of(waiting, _seconds_per_stage(plan, records, settings.scan.points)) / workers
    return Outlook(
        waiting=waiting,
        stored=len(plan.tasks) - sum(waiting.values()),
        rows=len(plan.rows),
        poses=_poses(plan),
        seconds=seconds,
        workers=workers,
        unavailable=plan.unavailable,
    )


def _poses(plan: Plan) -> dict[str, tuple[str, ...]]:
    """Poses that occur in the rows of each data set, in the order of the rows."""
    found: dict[str, dict[str, None]] = defaultdict(dict)
    for row in plan.rows:
        found[row.columns["dataset"]] |= {row.columns["source_pose"]: None, row.columns["target_pose"]: None}
    return {name: tuple(poses) for name, poses in found.items()}


def _seconds_per_stage(
    plan: Plan, records: Mapping[str, Mapping[str, Any] | None], points: int
) -> dict[str, float]:
    """Mean seconds of the stored results by stage; typical ones where nothing is stored.

    Operators take time in proportion to the points, maps hardly more for more of them (docs/matching.md).
    """
    found = dict(TYPICAL)
    found["operator"] *= points / TYPICAL_POINTS
    taken: dict[str, list[float]] = defaultdict(list)
    for key, record in records.items():
        if record is not None:
            taken[plan.tasks[key].stage].append(float(record["seconds"]))
    return found | {stage: sum(each) / len(each) for stage, each in taken.items()}

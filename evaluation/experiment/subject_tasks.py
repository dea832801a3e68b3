"""Tasks of one subject, entered into a plan as they are needed."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from datasets_gen.fingerprints import seed_of
from datasets_gen.records import InputError
from evaluation.experiment.experiment import Experiment
from evaluation.experiment.sections import Condition, Dataset
from evaluation.experiment.settings import reject_unknown
from evaluation.running.tasks import Task

FLOOR = 0.05
"""Renders keep peaks from here on, so that one render serves every threshold above."""


@dataclass(frozen=True, slots=True)
class Row:
    """A row of the table: what it is about, and the score that fills it."""

    columns: Mapping[str, Any]
    score: str


@dataclass
class Plan:
    """Tasks by key, inputs before the tasks that need them, and the rows they end in."""

    tasks: dict[str, Task] = field(default_factory=dict)
    rows: list[Row] = field(default_factory=list)
    unavailable: dict[str, str] = field(default_factory=dict)
    """Labels of methods that cannot run here, and why."""

    def add(self, task: Task) -> str:
        """Enter a task once; returns its key."""
        self.tasks.setdefault(task.key, task)
        return task.key


def scanner_settings(condition: Condition) -> dict[str, Any]:
    """The scanner of a render that serves a condition and every threshold above the floor."""
    floor = min(FLOOR, condition.threshold)
    return {**condition.scanner, "views": condition.views, "peak_threshold": floor}


class Subject:
    """Enters the tasks of one subject; each helper returns the key of its task."""

    def __init__(
        self,
        experiment: Experiment,
        plan: Plan,
        name: str,
        shape: str,
        about: Mapping[str, Any],
        dataset: Dataset,
    ) -> None:
        self.experiment, self.plan, self.name, self.shape = experiment, plan, name, shape
        self.subject, self.reference = str(about["subject"]), str(about["reference"])
        self.poses = _poses(dataset, about)

    def render(self, pose: str, condition: Condition, seed: int) -> str:
        """All that the scanner acquires of a pose."""
        spec = {
            "pose": pose,
            "scanner": scanner_settings(condition),
            "seed": seed_of("render", self.subject, pose, seed),
        }
        label = f"{self.name} {pose} {condition.views} views"
        return self.plan.add(Task.of("render", spec, {"shape": self.shape}, label))

    def cloud(self, pose: str, condition: Condition, seed: int) -> str:
        """The cloud that a condition makes of a pose."""
        spec = {
            "pose": pose,
            "threshold": condition.threshold,
            "points": condition.points,
            "rotation": condition.rotation,
            "scale": condition.scale,
            "seed": seed_of("cloud", self.subject, pose, seed),
        }
        inputs = {"shape": self.shape, "render": self.render(pose, condition, seed)}
        return self.plan.add(Task.of("scan", spec, inputs, f"{self.name} {pose} tau {condition.threshold}"))

    def ideal(self, seed: int) -> str:
        """The well-sampled rest pose."""
        spec = {
            "pose": self.reference,
            "ideal": True,
            "points": self.experiment.scan.points,
            "seed": seed_of("ideal", self.subject, seed),
        }
        return self.plan.add(
            Task.of("scan", spec, {"shape": self.shape}, f"{self.name} {self.reference} ideal")
        )

    def operator(self, scan: str, operator: str) -> str:
        """An operator of a cloud."""
        settings = self.experiment.operators
        spec = {"operator": operator, "modes": settings.modes, "options": dict(getattr(settings, operator))}
        label = f"{self.plan.tasks[scan].label} {operator}"
        return self.plan.add(Task.of("operator", spec, {"scan": scan}, label))


def _poses(dataset: Dataset, about: Mapping[str, Any]) -> list[str]:
    """Poses to use, in the data set's order; a number takes the reference first."""
    known, wanted = list(about["poses"]), dataset.poses
    if isinstance(wanted, tuple):
        reject_unknown(wanted, known, f"data set {dataset.name!r}", "pose")
        return list(dict.fromkeys(wanted))
    if isinstance(wanted, int):
        first = [about["reference"]] if about["reference"] in known else []
        ordered = first + [pose for pose in known if pose != about["reference"]]
        if wanted > len(ordered):
            raise InputError(f"data set {dataset.name!r} has {len(ordered)} poses, {wanted} were asked for")
        return ordered[:wanted]
    return known

"""Tasks of one subject: renders, clouds and operators, entered into a plan as they are needed."""

from collections.abc import Mapping
from typing import Any

from datasets_gen.fingerprints import seed_of
from datasets_gen.records import InputError
from evaluation.experiment.config_sections import SURFACE, DatasetSection, ScanCondition
from evaluation.experiment.experiment import Experiment
from evaluation.experiment.plan import Plan
from evaluation.experiment.tasks import Task
from evaluation.experiment.toml_tables import reject_unknown
from scanner_sim import presets

FLOOR = 0.05
"""Lowest peak that a render keeps, so that one render serves every threshold above."""


def scanner_settings(condition: ScanCondition) -> dict[str, Any]:
    """The scanner of a render that serves a condition and every threshold above the floor."""
    floor = min(FLOOR, condition.threshold)
    return {**presets.expanded(condition.scanner), "views": condition.views, "peak_threshold": floor}


def operator_options(experiment: Experiment, operator: str) -> dict[str, Any]:
    """Arguments of `Diffusion.from_points`: those of the operator's section, over the departures of all."""
    common = {} if experiment.departures == "all" else {"departures": experiment.departures}
    return {**common, **getattr(experiment.operators, operator)}


class SubjectPlan:
    """Enters the tasks of one subject into a plan; each method returns the key of its task.

    Parameters
    ----------
    experiment
    plan
        Filled.
    name
        Of the data set in tables.
    shape
        Key of the task that loads the data set.
    about
        ``subject``, ``poses`` and ``reference`` of the data set.
    dataset
        Which poses to use.

    Raises
    ------
    InputError
        If the data set lacks a pose that is asked for.
    """

    def __init__(
        self,
        experiment: Experiment,
        plan: Plan,
        name: str,
        shape: str,
        about: Mapping[str, Any],
        dataset: DatasetSection,
    ) -> None:
        self.experiment, self.plan, self.name, self.shape = experiment, plan, name, shape
        self.subject, self.reference = str(about["subject"]), str(about["reference"])
        self.poses = poses_used(dataset, about)

    def render(self, pose: str, condition: ScanCondition, seed: int) -> str:
        """All that the scanner acquires of a pose."""
        spec = {
            "pose": pose,
            "scanner": scanner_settings(condition),
            "seed": seed_of("render", self.subject, pose, seed),
        }
        label = f"{self.name} {pose} {condition.views} views"
        return self.plan.add(Task.of("render", spec, {"shape": self.shape}, label))

    def cloud(self, pose: str, condition: ScanCondition, seed: int) -> str:
        """The cloud that a condition makes of a pose."""
        spec: dict[str, Any] = {
            "pose": pose,
            "points": condition.points,
            "rotation": condition.rotation,
            "scale": condition.scale,
            "seed": seed_of("cloud", self.subject, pose, seed),
        }
        if condition.views == SURFACE:
            label = f"{self.name} {pose} surface"
            return self.plan.add(Task.of("scan", {**spec, "surface": True}, {"shape": self.shape}, label))
        spec["threshold"] = condition.threshold
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
        options = operator_options(self.experiment, operator)
        spec = {"operator": operator, "modes": self.experiment.operators.modes, "options": options}
        label = f"{self.plan.tasks[scan].label} {operator}"
        return self.plan.add(Task.of("operator", spec, {"scan": scan}, label))


def poses_used(dataset: DatasetSection, about: Mapping[str, Any]) -> list[str]:
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

"""From an experiment to tasks and the rows of its table."""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from datasets_gen.records import InputError
from datasets_gen.registry import names
from evaluation.experiment import Condition, Dataset, Experiment, Method, Regime
from evaluation.identity import digest_files, seed_of
from evaluation.methods.base import Method as MethodClass
from evaluation.methods.registry import create, method_version, missing
from evaluation.settings import reject_unknown
from evaluation.tasks import Task

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


def shape_tasks(experiment: Experiment) -> dict[str, Task]:
    """One task per data set, by the name the table shows."""
    found: dict[str, Task] = {}
    for dataset in experiment.dataset:
        name = display_name(dataset)
        if name in found:
            raise InputError(f"two data sets are called {name!r}; rename one of the folders")
        folder = Path(dataset.name)
        if not folder.is_dir():
            reject_unknown([dataset.name], names(), "experiment", "data set (and no folder of that name)")
        files = [path for path in folder.iterdir() if path.is_file()] if folder.is_dir() else []
        spec = {"name": str(folder.resolve()) if files else dataset.name, "options": dict(dataset.options)}
        code = digest_files(*files) if files else ""
        identity = {**spec, "name": name} if files else spec
        task = Task.of("shape", identity, {}, name, code)
        found[name] = Task(task.key, task.stage, spec, task.inputs, task.label)
    return found


def display_name(dataset: Dataset) -> str:
    """Name of a data set in tables: folders go by their last part."""
    path = Path(dataset.name)
    return path.resolve().name if path.is_dir() else dataset.name


def make_plan(
    experiment: Experiment, shapes: Mapping[str, Task], known: Mapping[str, Mapping[str, Any]]
) -> Plan:
    """All tasks of an experiment.

    Parameters
    ----------
    experiment
    shapes
        From `shape_tasks`.
    known
        What the shape tasks noted, by name of the data set: ``subject``, ``poses``, ``reference``. A data set
        that is not there (its shape failed, or was not made yet) is left out.

    Raises
    ------
    InputError
        If a pose, method or option is unknown.
    """
    plan = Plan()
    for task in shapes.values():
        plan.add(task)
    methods = {}
    for each in experiment.method:
        method = create(each.name, each.options)
        methods[each.label] = (method, method_version(each.name, method))
    plan.unavailable = {each.label: reason for each in experiment.method if (reason := missing(each.name))}
    for dataset in experiment.dataset:
        name = display_name(dataset)
        if name not in known:
            continue
        subject = _Subject(experiment, plan, name, shapes[name].key, known[name], dataset)
        for seed in experiment.seeds:
            _plan_stability(subject, seed)
            _plan_matching(subject, seed, methods)
    return plan


class _Subject:
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
        floor = min(FLOOR, condition.threshold)
        scanner = {**condition.scanner, "views": condition.views, "peak_threshold": floor}
        spec = {"pose": pose, "scanner": scanner, "seed": seed_of("render", self.subject, pose, seed)}
        label = f"{self.name} {pose} {condition.views} views"
        return self.plan.add(Task.of("render", spec, {"shape": self.shape}, label))

    def cloud(self, pose: str, condition: Condition, seed: int) -> str:
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


def _plan_stability(subject: _Subject, seed: int) -> None:
    experiment = subject.experiment
    if experiment.stability is None:
        return
    settings, spec = experiment.stability, dict[str, Any]()
    for operator in settings.operators:
        ideal = subject.ideal(seed)
        reference = subject.operator(ideal, operator)
        base: dict[str, Any] = {
            "kind": "stability",
            "dataset": subject.name,
            "subject": subject.subject,
            "seed": seed,
        }
        base |= {"method": operator, "operator": operator, "target_pose": subject.reference}
        clouds: list[tuple[str, dict[str, Any]]] = [
            (ideal, {"source_pose": subject.reference, "regime": "reference", "source_threshold": None})
        ]
        for name, condition in experiment.stability_conditions():
            for pose in subject.poses:
                about = {"source_pose": pose, "regime": name, "source_threshold": condition.threshold}
                about["views"] = str(condition.views)
                clouds.append((subject.cloud(pose, condition, seed), about))
        for cloud, about in clouds:
            inputs = {"shape": subject.shape, "scan": cloud, "reference_operator": reference}
            inputs["operator"] = subject.operator(cloud, operator)
            spec = {"kind": "stability", "pairs": settings.pairs, "times": settings.times}
            spec["seed"] = seed_of("pairs", subject.subject, seed)
            label = f"{subject.plan.tasks[cloud].label} {operator} eq18"
            score = subject.plan.add(Task.of("score", spec, inputs, label))
            keys = {"source_scan": cloud, "target_scan": ideal, "source_operator": inputs["operator"]}
            subject.plan.rows.append(Row({**base, **about, **keys, "score_key": score}, score))


def _plan_matching(subject: _Subject, seed: int, methods: Mapping[str, tuple[MethodClass, str]]) -> None:
    for regime in subject.experiment.regimes():
        for source, target in _pairs(subject):
            for choice in subject.experiment.method:
                if choice.label not in subject.plan.unavailable:
                    _plan_map(subject, seed, regime, (source, target), choice, *methods[choice.label])


def _plan_map(
    subject: _Subject,
    seed: int,
    regime: Regime,
    pair: tuple[str, str],
    choice: Method,
    method: MethodClass,
    version: str,
) -> None:
    clouds = {
        "source": subject.cloud(pair[0], regime.source, seed),
        "target": subject.cloud(pair[1], regime.target, seed),
    }
    inputs = {"shape": subject.shape, **{f"{side}_scan": key for side, key in clouds.items()}}
    for operator in method.operators:
        inputs |= {f"{side}_{operator}": subject.operator(key, operator) for side, key in clouds.items()}
    spec: dict[str, Any] = {"method": choice.name, "options": dict(choice.options)}
    spec["seed"] = seed_of("map", subject.subject, *pair, seed)
    label = f"{subject.name} {pair[0]} to {pair[1]} {choice.label}"
    found = subject.plan.add(Task.of("map", spec, inputs, label, version))
    ideal = subject.ideal(seed)
    inputs = {"shape": subject.shape, **{f"{side}_scan": key for side, key in clouds.items()}, "map": found}
    inputs["reference_medial"] = subject.operator(ideal, "medial")
    spec = {"kind": "matching", "evaluated": subject.experiment.evaluated}
    spec["seed"] = seed_of("evaluated", subject.subject, *pair, seed)
    score = subject.plan.add(Task.of("score", spec, inputs, f"{label} error"))
    columns = {
        "kind": "matching",
        "dataset": subject.name,
        "subject": subject.subject,
        "method": choice.label,
        "operator": "+".join(method.operators) or None,
        "source_pose": pair[0],
        "source_threshold": regime.source.threshold,
        "target_pose": pair[1],
        "target_threshold": regime.target.threshold,
        "regime": regime.name,
        "views": str(regime.source.views),
        "seed": seed,
        "source_scan": clouds["source"],
        "target_scan": clouds["target"],
        "map_key": found,
        "score_key": score,
    }
    subject.plan.rows.append(Row(columns, score))


def _pairs(subject: _Subject) -> list[tuple[str, str]]:
    """Ordered pairs of poses to match."""
    assert subject.experiment.matching is not None
    rule, poses = subject.experiment.matching.pairs, subject.poses
    every = [(a, b) for a in poses for b in poses if a != b]
    if rule == "reference":
        return [(subject.reference, pose) for pose in poses if pose != subject.reference]
    if rule == "chain":
        return list(itertools.pairwise(poses))
    if rule == "all":
        return every
    if isinstance(rule, int):
        rng = np.random.default_rng(seed_of("pairs", subject.subject))
        return [every[i] for i in sorted(rng.permutation(len(every))[:rule])]
    for pair in rule:
        reject_unknown(pair, poses, f"matching pairs, data set {subject.name!r}", "pose")
    return [(str(a), str(b)) for a, b in rule]

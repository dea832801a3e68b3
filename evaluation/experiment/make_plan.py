"""From an experiment to its plan: the tasks of every stage and the rows of the table."""

import itertools
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from datasets_gen.collection import no_truth
from datasets_gen.collections.layouts import files_read
from datasets_gen.fingerprints import digest_files, seed_of
from datasets_gen.records import InputError
from datasets_gen.registry import is_folder, names
from evaluation.experiment.config_sections import SURFACE, DatasetSection, MethodSection, Regime
from evaluation.experiment.experiment import Experiment
from evaluation.experiment.plan import Plan, PlannedRow
from evaluation.experiment.subject_plan import SubjectPlan, operator_options, scanner_settings
from evaluation.experiment.tasks import Task
from evaluation.experiment.toml_tables import reject_unknown
from evaluation.methods.base import Method
from evaluation.methods.catalogue import create, method_version, missing
from medial.operator import OPERATORS, Operator
from scanner_sim import ScannerConfig, presets


def shape_tasks(experiment: Experiment) -> dict[str, Task]:
    """One task per data set, by the name the table shows."""
    found: dict[str, Task] = {}
    for dataset in experiment.dataset:
        name = display_name(dataset)
        if name in found:
            raise InputError(f"two data sets are called {name!r}; rename one of the folders")
        path, files = Path(dataset.name), []
        if is_folder(dataset.name):
            files = files_read(path)
        else:
            reject_unknown([dataset.name], names(), "experiment", "data set (and no folder of that name)")
        spec = {"name": str(path.resolve()) if files else dataset.name, "options": dict(dataset.options)}
        code = digest_files(*files, root=path if path.is_dir() else path.parent) if files else ""
        identity = {**spec, "name": name} if files else spec
        task = Task.of("shape", identity, {}, name, code)
        found[name] = Task(task.key, task.stage, spec, task.inputs, task.label)
    return found


def display_name(dataset: DatasetSection) -> str:
    """Name of a data set in tables: paths go by their last part, and the subject if one is chosen."""
    if not is_folder(dataset.name):
        return dataset.name
    path = Path(dataset.name)
    last = path.resolve().name if path.is_dir() else path.stem
    return "-".join([last, *([str(s)] if (s := dataset.options.get("subject")) else [])])


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
        By name of the data set: ``subject``, ``poses``, ``reference``, as a shape task notes them or
        `datasets_gen.registry.outline` tells them.

    Raises
    ------
    InputError
        If a pose, method or option is unknown, or a data set has no ground truth.
    """
    _check(experiment)
    for about in known.values():
        if about.get("truth") is False:
            raise InputError(no_truth(str(about["subject"])))
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
        subject = SubjectPlan(experiment, plan, name, shapes[name].key, known[name], dataset)
        for seed in experiment.seeds:
            _plan_stability(subject, seed)
            _plan_matching(subject, seed, methods)
    return plan


def _check(experiment: Experiment) -> None:
    """Settings that are passed on: to the scanner and to operators.

    Raises
    ------
    InputError
        If one is unknown or refused there.
    """
    conditions = [condition for _, condition in experiment.stability_conditions()]
    conditions += [condition for each in experiment.regimes() for condition in (each.source, each.target)]
    for condition in conditions:
        if condition.views == SURFACE:
            continue
        reject_unknown(condition.scanner, [*(f.name for f in fields(ScannerConfig)), presets.KEY], "scanner")
        ScannerConfig.from_dict(scanner_settings(condition))
    known = [f.name for f in fields(Operator) if f.name not in ("operator", "modes")]
    for name in OPERATORS:
        given = operator_options(experiment, name)
        reject_unknown(given, known, f"[operators] {name}")
        Operator(operator=name, modes=experiment.operators.modes, **given)


def _plan_stability(subject: SubjectPlan, seed: int) -> None:
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
        clouds: list[tuple[str, float, dict[str, Any]]] = [
            (ideal, 1.0, {"source_pose": subject.reference, "regime": "reference", "source_threshold": None})
        ]
        for name, condition in experiment.stability_conditions():
            for pose in subject.poses:
                about = {"source_pose": pose, "regime": name, "source_threshold": condition.threshold}
                about["views"] = str(condition.views)
                clouds.append((subject.cloud(pose, condition, seed), condition.scale, about))
        for cloud, scale, about in clouds:
            inputs = {"shape": subject.shape, "scan": cloud, "reference_operator": reference}
            inputs["operator"] = subject.operator(cloud, operator)
            spec = {"kind": "stability", "pairs": settings.pairs, "times": settings.times, "scale": scale}
            spec["seed"] = seed_of("pairs", subject.subject, seed)
            label = f"{subject.plan.tasks[cloud].label} {operator} eq18"
            score = subject.plan.add(Task.of("score", spec, inputs, label))
            keys = {"source_scan": cloud, "target_scan": ideal, "source_operator": inputs["operator"]}
            subject.plan.rows.append(PlannedRow({**base, **about, **keys, "score_key": score}, score))


def _plan_matching(subject: SubjectPlan, seed: int, methods: Mapping[str, tuple[Method, str]]) -> None:
    for regime in subject.experiment.regimes():
        for source, target in _pairs(subject):
            for choice in subject.experiment.method:
                if choice.label not in subject.plan.unavailable:
                    _plan_map(subject, seed, regime, (source, target), choice, *methods[choice.label])


def _plan_map(
    subject: SubjectPlan,
    seed: int,
    regime: Regime,
    pair: tuple[str, str],
    choice: MethodSection,
    method: Method,
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
    task = Task.of("map", _without_places(spec), inputs, label, version)
    found = subject.plan.add(replace(task, spec=spec))
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
        "target_views": str(regime.target.views),
        "seed": seed,
        "source_scan": clouds["source"],
        "target_scan": clouds["target"],
        "map_key": found,
        "score_key": score,
    }
    subject.plan.rows.append(PlannedRow(columns, score))


def _without_places(spec: Mapping[str, Any]) -> dict[str, Any]:
    """What of a map its key names: files by their names, as `method_version` covers their contents."""
    file, colon, attribute = spec["method"].rpartition(":")
    method = Path(file).name + colon + attribute if file.endswith(".py") else spec["method"]
    options = dict(spec["options"])
    if method == "external":
        options["folder"] = Path(str(options.get("folder"))).name
    return {**spec, "method": method, "options": options}


def _pairs(subject: SubjectPlan) -> list[tuple[str, str]]:
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

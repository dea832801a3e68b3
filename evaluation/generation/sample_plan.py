"""Which sample is what: a pure function of the settings, the split and a number.

Sample i is the same whatever the number of samples, the size of the shards, the number of workers and the
order in which they run, so any one can be made again alone, and a larger set begins with the smaller one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from datasets_gen.collections.layouts import layout_of
from datasets_gen.fingerprints import seed_of
from datasets_gen.records import InputError
from datasets_gen.registry import SOURCES, held_out, outline
from evaluation.experiment.config_sections import SURFACE, DatasetSection, ScanCondition
from evaluation.experiment.make_plan import display_name
from evaluation.experiment.subject_plan import poses_used
from evaluation.generation.generation_config import GenerationConfig
from scanner_sim import presets
from scanner_sim.optics.viewpoints import directions

SPLITS = ("train", "val")
DIGITS = 4
"""Decimal places of thresholds."""


@dataclass(frozen=True)
class SampleIdentity:
    """What one sample is made of.

    Attributes
    ----------
    split : str
        ``"train"`` or ``"val"``.
    index : int
        Within the split.
    render : int
        Number of the acquisition that it shares with its neighbours, within the split.
    dataset : str
        Name of the data set.
    individual : str
        Who was scanned; no individual is in both splits.
    pose : str
        As in the data set.
    held_out : bool
        Whether body or pose are kept from tuning.
    condition : ScanCondition
        Threshold and viewpoints as drawn.
    render_seed, seed : int
        Of the scanner's noise, and of the choice of points and the turn of the finished cloud.
    """

    split: str
    index: int
    render: int
    dataset: str
    individual: str
    pose: str
    held_out: bool
    condition: ScanCondition
    render_seed: int
    seed: int

    @property
    def key(self) -> str:
        """Name of the sample: ``train-00000012``."""
        return f"{self.split}-{self.index:08d}"


@dataclass(frozen=True)
class SampledSet:
    """One data set as it is drawn from.

    Attributes
    ----------
    name : str
    section : DatasetSection
    subject, reference : str
        As its `outline` tells.
    individuals : Mapping of str to str
        By pose, in the data set's order.
    validation : frozenset of str
        Individuals of the split ``val``.
    held_out : frozenset of str
        Poses that are kept from tuning.
    """

    name: str
    section: DatasetSection
    subject: str
    reference: str
    individuals: Mapping[str, str]
    validation: frozenset[str]
    held_out: frozenset[str]

    def poses(self, split: str) -> tuple[str, ...]:
        """Poses of a split, in the data set's order."""
        kept = split == "val"
        return tuple(pose for pose, who in self.individuals.items() if (who in self.validation) is kept)


class SamplePlan:
    """All samples of a configuration, each told when asked for.

    Parameters
    ----------
    config
    known
        By name of the data set: ``subject``, ``poses`` and ``reference`` (`outlines`).

    Raises
    ------
    InputError
        If two data sets have one name, a pose is unknown, or one is held out and that was not asked for.
    """

    def __init__(self, config: GenerationConfig, known: Mapping[str, Mapping[str, Any]]) -> None:
        self.config = config
        self.sets = tuple(_sampled_set(config, each, known[display_name(each)]) for each in config.dataset)
        self._poses = {
            split: [(each, poses) for each in self.sets if (poses := each.poses(split))] for split in SPLITS
        }

    def counts(self, samples: int) -> dict[str, int]:
        """Samples of each split that make so many together; none of a split without subjects."""
        kept = round(samples * self.config.validation) if self._poses["val"] else 0
        return {"train": samples - kept, "val": kept}

    def identity(self, split: str, index: int) -> SampleIdentity:
        """What a sample is made of.

        Data sets take turns; of each, every pose of the split comes once before any comes again.
        """
        config, draw = self.config, self.config.draw
        render, part = divmod(index, draw.per_render)
        sets = self._poses[split]
        turn, which = divmod(render, len(sets))
        chosen, poses = sets[which]
        cycle, place = divmod(turn, len(poses))
        order = np.random.default_rng(seed_of("order", config.seed, split, chosen.name, cycle))
        pose = poses[order.permutation(len(poses))[place]]
        render_seed = seed_of("generated render", config.seed, split, render)
        condition = _drawn(config, np.random.default_rng(render_seed), part)
        return SampleIdentity(
            split=split,
            index=index,
            render=render,
            dataset=chosen.name,
            individual=chosen.individuals[pose],
            pose=pose,
            held_out=pose in chosen.held_out,
            condition=condition,
            render_seed=render_seed,
            seed=seed_of("generated sample", config.seed, split, index),
        )

    def set_named(self, name: str) -> SampledSet:
        """The data set of a name."""
        return next(each for each in self.sets if each.name == name)


def outlines(config: GenerationConfig) -> dict[str, dict[str, Any]]:
    """Subject, poses and reference of every data set, told without building one.

    Raises
    ------
    InputError
        If two data sets have one name, one is unknown or cannot be used, or its package is missing.
    """
    found: dict[str, dict[str, Any]] = {}
    for each in config.dataset:
        name = display_name(each)
        if name in found:
            raise InputError(
                f"two data sets are called {name!r}; rename one of the folders, or have several bodies "
                "of one kind by options = { subjects = N }"
            )
        found[name] = outline(each.name, **each.options)
    return found


def _sampled_set(config: GenerationConfig, section: DatasetSection, about: Mapping[str, Any]) -> SampledSet:
    name = display_name(section)
    poses = poses_used(section, about)
    kept = _held_out(section, poses)
    if kept and not config.held_out:
        what = "it" if len(kept) == len(poses) else f"its pose {kept[0]!r}"
        raise InputError(
            f"data set {name!r}: {what} is held out, so that results on it tell of unseen shapes; leave it "
            "out, or set held_out = true, which marks the samples"
        )
    individuals = {pose: _individual(section, str(about["subject"]), pose) for pose in poses}
    of_reference = _individual(section, str(about["subject"]), str(about["reference"]))
    everyone = sorted(  # the one of the reference comes last, and so is no one to validate with
        set(individuals.values()),
        key=lambda who: (who == of_reference, seed_of("split", config.seed, name, who)),
    )
    share = config.validation
    count = max(round(share * len(everyone)), 1) if share and len(everyone) > 1 else 0
    return SampledSet(
        name=name,
        section=section,
        subject=str(about["subject"]),
        reference=str(about["reference"]),
        individuals=individuals,
        validation=frozenset(everyone[:count]),
        held_out=frozenset(kept),
    )


def _held_out(section: DatasetSection, poses: Sequence[str]) -> list[str]:
    """Poses that are kept from tuning; asked of all at once first, as hardly any is."""
    if not held_out(section.name, **{**section.options, "poses": poses}):
        return []
    return [pose for pose in poses if held_out(section.name, **{**section.options, "poses": [pose]})]


def _individual(section: DatasetSection, subject: str, pose: str) -> str:
    """Who has a pose: of several bodies in one collection, whom its name tells; else the subject."""
    if section.name in SOURCES:
        several = max(section.options.get("subjects", 1), section.options.get("people", 1)) > 1
        return f"{subject}/{pose.partition('-')[0]}" if several else subject
    faust = layout_of(Path(section.name)).name == "FAUST"
    return f"{subject}/{int(pose[-3:]) // 10}" if faust else subject


def _drawn(config: GenerationConfig, rng: np.random.Generator, part: int) -> ScanCondition:
    """The condition of one sample of a render."""
    draw = config.draw
    values = {key: each[int(rng.integers(len(each)))] for key, each in sorted(draw.sweep.items())}
    condition = config.scan.with_values(values)
    angle, axis = rng.uniform(0, 2 * np.pi), rng.normal(size=4)
    places = rng.permutation(draw.per_render), rng.random(draw.per_render)
    low, high = draw.threshold
    share = (places[0][part] + places[1][part]) / draw.per_render
    threshold = min(max(round(low + (high - low) * float(share), DIGITS), low), high)
    condition = replace(condition, threshold=float(threshold))
    if condition.views == SURFACE or draw.turn == "none":
        return condition
    up = str(presets.expanded(condition.scanner).get("up", "y"))
    about_up = Rotation.from_rotvec(angle * np.eye(3)["xyz".index(up)])
    turn = Rotation.from_quat(axis) if draw.turn == "any" else about_up
    toward = turn.apply(directions(condition.views, up))
    return replace(condition, views=tuple(tuple(round(float(x), 9) for x in each) for each in toward))


def shard_ranges(counts: Mapping[str, int], size: int) -> Sequence[tuple[str, int, int, int]]:
    """Split, number, first sample and number of samples of every shard; the last may have fewer."""
    return [
        (split, first // size, first, min(size, counts[split] - first))
        for split in SPLITS
        for first in range(0, counts[split], size)
    ]

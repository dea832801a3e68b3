"""The tasks that make a folder of training data, and what the folder is told of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from datasets_gen.collections.folder import code_version
from datasets_gen.collections.layouts import files_read
from datasets_gen.fingerprints import code_fingerprint, digest, digest_files
from datasets_gen.paths import distinct_names
from datasets_gen.records import InputError
from datasets_gen.values import check_count
from evaluation.experiment.tasks import Task
from evaluation.generation.generated_folder import FORMAT, GeneratedFolder
from evaluation.generation.generation_config import GenerationConfig
from evaluation.generation.sample_plan import SamplePlan, outlines, shard_ranges

CODE = "evaluation.generation.sample_making"
"""Module whose code, with all that it imports, decides the samples."""
MOST_SHARDS = 100_000
"""Files of one folder, which file systems and loaders still take, and names of six digits."""
FREE = ("name", "description", "timeout")
"""Settings that decide no sample."""


@dataclass(frozen=True)
class GenerationPlan:
    """What is to be made in a folder.

    Attributes
    ----------
    config : GenerationConfig
    samples : SamplePlan
    counts : Mapping of str to int
        Samples by split.
    references, shards : tuple of Task
    state : Mapping
        What decides the samples, as it is kept in the folder.
    """

    config: GenerationConfig
    samples: SamplePlan
    counts: Mapping[str, int]
    references: tuple[Task, ...]
    shards: tuple[Task, ...]
    state: Mapping[str, Any]

    @property
    def tasks(self) -> tuple[Task, ...]:
        """References, then shards."""
        return (*self.references, *self.shards)


def make_generation_plan(config: GenerationConfig, samples: int, shard_size: int) -> GenerationPlan:
    """Plan the files of a number of samples.

    Parameters
    ----------
    config
    samples
        Of both splits together.
    shard_size
        Samples per shard.

    Raises
    ------
    InputError
        If a data set cannot be used, a number is less than 1, or there would be too many shards.
    """
    check_count(samples, "number of samples")
    check_count(shard_size, "shard size")
    if samples > MOST_SHARDS * shard_size:
        raise InputError(
            f"{samples:,} samples in shards of {shard_size:,} are more than {MOST_SHARDS:,} files; "
            "ask for fewer, or for larger shards (--shard-size)"
        )
    known = outlines(config)
    plan = SamplePlan(config, known)
    counts = plan.counts(samples)
    state = _state(config, plan, known, shard_size)
    common = {"settings": config.as_dict(), "known": known}
    identity = [state["samples"], state["code"]]
    names = distinct_names([each.name for each in plan.sets], "data set")
    references = [
        _task("reference", identity, f"references/{safe}.npz", {"dataset": name}, common)
        for name, safe in names.items()
    ]
    shards = [
        _task(
            "shard",
            identity,
            f"{split}-{number:06d}.tar",
            {"split": split, "first": first, "count": count},
            common,
        )
        for split, number, first, count in shard_ranges(counts, shard_size)
    ]
    return GenerationPlan(config, plan, counts, tuple(references), tuple(shards), state)


def _task(
    stage: str, identity: list[Any], file: str, what: Mapping[str, Any], common: Mapping[str, Any]
) -> Task:
    key = f"{stage}-{Path(file).stem}-{digest([identity, file, what])[:16]}"
    return Task(key, stage, {"file": file, **what, **common}, {}, file)


def _state(
    config: GenerationConfig, plan: SamplePlan, known: Mapping[str, Any], shard_size: int
) -> dict[str, Any]:
    """What decides the samples; of a folder its name and the content of its files, not where it lies."""
    settings = {key: value for key, value in config.as_dict().items() if key not in FREE}
    contents = {}
    for each, table in zip(plan.sets, settings["dataset"], strict=True):
        folder = Path(each.section.name)
        if folder.is_dir():
            contents[each.name] = digest_files(*files_read(folder), root=folder)
            table["name"] = folder.name
    return {
        "format": FORMAT,
        "settings": settings,
        "shard_size": shard_size,
        "samples": digest([settings, known, contents]),
        "contents": contents,
        "code": code_fingerprint(CODE),
        "medialbench": code_version(),
    }


def check_folder_kept(folder: GeneratedFolder, plan: GenerationPlan) -> None:
    """Raise InputError if a folder holds other samples than are planned, which would be mixed or lost."""
    before, where = folder.state(), repr(str(folder.path))
    remedy = "use another folder, or --force, which makes all again"
    if before is None:
        return
    if before.get("format") != FORMAT:
        raise InputError(f"{where} holds training data of another format ({before.get('format')}); {remedy}")
    if before["samples"] != plan.state["samples"]:
        changed = _first_difference(before["settings"], dict(plan.state["settings"]))
        raise InputError(f"{where} holds samples of other settings ({changed}); {remedy}")
    if before["code"] != plan.state["code"]:
        version = f"version {before['medialbench']} or with other libraries"
        raise InputError(f"{where} holds samples made by other code ({version}); {remedy}")
    if before["shard_size"] != plan.state["shard_size"]:
        raise InputError(
            f"{where} holds shards of {before['shard_size']} samples, not {plan.state['shard_size']}; "
            f"give --shard-size {before['shard_size']}, or {remedy}"
        )
    planned = {task.spec["file"] for task in plan.shards}
    surplus = [name for name in folder.shards() if name not in planned]
    if surplus:
        raise InputError(f"{where} holds more samples than are asked for ({surplus[0]}); {remedy}")


def _first_difference(before: Any, now: Any, name: str = "") -> str:
    """Name of the first setting that differs, with both values."""
    if isinstance(before, dict) and isinstance(now, dict):
        for key in [*before, *(key for key in now if key not in before)]:
            if digest(before.get(key)) != digest(now.get(key)):
                return _first_difference(before.get(key), now.get(key), f"{name}.{key}".lstrip("."))
    if isinstance(before, list | tuple) and isinstance(now, list | tuple) and len(before) == len(now):
        for number, (one, other) in enumerate(zip(before, now, strict=True)):
            if digest(one) != digest(other):
                return _first_difference(one, other, f"{name}[{number}]")
    return f"{name} was {before!r}, is {now!r}" if name else "files of a data set have changed"

"""What describes generated training data: dataset.json for programs, DATASHEET.md for people, two tables."""

import csv
import json
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from datasets_gen.collections.folder import read_manifest
from datasets_gen.collections.layouts import layout_of
from datasets_gen.fingerprints import digest
from datasets_gen.records import atomic_path
from datasets_gen.registry import SOURCES, provenance
from evaluation.generation.generated_folder import FORMAT, GeneratedFolder
from evaluation.generation.generation_plan import GenerationPlan
from evaluation.generation.sample_plan import SPLITS, SampledSet
from evaluation.results.outcome import Outcome
from evaluation.results.store import write_json
from evaluation.running.environment import machine, versions

COLUMNS = (
    "key",
    "shard",
    "dataset",
    "individual",
    "pose",
    "held_out",
    "seed",
    "threshold",
    "views",
    "points",
    "missing",
)
"""Of samples.csv."""
UNKNOWN_TERMS = "not stated in the folder; ask where it comes from"


def write_summary(
    folder: GeneratedFolder, plan: GenerationPlan, failed: Sequence[Outcome]
) -> list[dict[str, Any]]:
    """Write everything that describes the folder as it is.

    Parameters
    ----------
    folder
    plan
    failed
        Tasks without a file.

    Returns
    -------
    list of dict
        Notes of the shards that are there (`GeneratedFolder.write_note`).
    """
    notes = [note for task in plan.shards if (note := folder.note(task)) and folder.file_of(task).is_file()]
    rows = [{**row, "shard": note["file"]} for note in notes for row in note["samples"]]
    missing = [each for note in notes for each in note["failures"]]
    missing += [{"key": each.task.label, "reason": each.reason} for each in failed]
    _write_csv(folder.path / "samples.csv", COLUMNS, rows)
    _write_csv(folder.path / "failures.csv", ("key", "dataset", "pose", "reason"), missing)
    facts = {
        **_origin(plan),
        "complete": len(rows) == sum(plan.counts.values()),
        "planned": dict(plan.counts),
        "samples": {split: sum(row["key"].startswith(f"{split}-") for row in rows) for split in SPLITS},
        "missing_samples": len(missing),
        "bytes": sum(note["bytes"] for note in notes),
        "shards": [
            {**{name: note[name] for name in ("file", "sha256", "bytes")}, "samples": len(note["samples"])}
            for note in notes
        ],
        "datasets": {each.name: _about_set(folder, plan, each, rows) for each in plan.samples.sets},
    }
    write_json(folder.path / "dataset.json", facts)
    with atomic_path(folder.path / "DATASHEET.md") as temporary:
        temporary.write_text(datasheet(facts), encoding="utf-8")
    return notes


def datasheet(facts: Mapping[str, Any]) -> str:
    """DATASHEET.md, after the questions of Gebru et al., of what dataset.json holds."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    pages = Environment(  # Markdown, no HTML: nothing is escaped but the bars of tables
        loader=PackageLoader("evaluation.generation", ""),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    pages.filters["cell"] = lambda text: str(text).replace("|", "/")
    text = pages.get_template("DATASHEET.md.j2").render(
        **facts,
        made=sum(facts["samples"].values()),
        planned_all=sum(facts["planned"].values()),
        licences=sorted({about["licence"] for about in facts["datasets"].values()}),
        held_out=any(about["held_out_poses"] for about in facts["datasets"].values()),
    )
    return text


def _origin(plan: GenerationPlan) -> dict[str, Any]:
    """What made the data: settings, seeds, versions."""
    config = plan.config
    settings = json.loads(json.dumps(config.as_dict()))
    return {
        "format": FORMAT,
        "name": config.name,
        "description": config.description,
        "settings": settings,
        "config_hash": digest(settings)[:16],
        "seed": config.seed,
        "shard_size": plan.state["shard_size"],
        "code": plan.state["code"],
        "versions": versions(),
        "machine": machine(),
        "finished": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
    }


def _about_set(
    folder: GeneratedFolder, plan: GenerationPlan, chosen: SampledSet, rows: Iterable[Mapping[str, Any]]
) -> dict[str, Any]:
    """Terms, splits, reference and statistics of one data set."""
    own = [row for row in rows if row["dataset"] == chosen.name]
    everyone = dict.fromkeys(chosen.individuals.values())
    task = next(each for each in plan.references if each.spec["dataset"] == chosen.name)
    note = folder.note(task) or {}
    return {
        **terms_of(chosen),
        "subject": chosen.subject,
        "individuals": {
            split: [who for who in everyone if (who in chosen.validation) == (split == "val")]
            for split in SPLITS
        },
        "held_out_poses": sorted(chosen.held_out),
        "reference": {
            "pose": chosen.reference,
            **{name: note.get(name) for name in ("file", "sha256", "vertices", "faces")},
        },
        "remarks": note.get("remarks", []),
        "statistics": _statistics(own),
    }


def _statistics(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    poses: dict[str, int] = defaultdict(int)
    for row in rows:
        number = row["individual"].rpartition("/")[2]
        poses[row["pose"].removeprefix(f"{number}-")] += 1
    return {
        "samples": len(rows),
        "poses": dict(poses),
        "viewpoints": dict(sorted(Counter(str(row["views"]) for row in rows).items())),
        **{
            name: _spread([row[name] for row in rows if row[name] is not None])
            for name in ("points", "threshold", "missing")
        },
    }


def _spread(values: Sequence[float]) -> dict[str, float] | None:
    """Least, mean and largest value; None of no values."""
    if not values:
        return None
    return {name: round(float(getattr(np, name)(values)), 6) for name in ("min", "mean", "max")}


def terms_of(chosen: SampledSet) -> dict[str, str]:
    """Licence and origin of the shapes of a data set, as the registry, its folder or its layout has them."""
    name = chosen.section.name
    if name in SOURCES:
        made = provenance(name, **chosen.section.options)
        return {"licence": str(made["licence"]), "source": str(made["source"])}
    layout, manifest = layout_of(Path(name)), read_manifest(Path(name))
    return {
        "licence": str(manifest.get("licence") or layout.terms or UNKNOWN_TERMS),
        "source": str(manifest.get("source") or layout.origin or f"folder {Path(name).name!r}"),
    }


def _write_csv(path: Path, columns: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> None:
    with atomic_path(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, columns, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)

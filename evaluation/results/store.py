"""The results folder: every result on its own, written under a temporary name and renamed.

::

    experiment.toml   the experiment, every setting spelled out
    run.json          versions, machine, wall time, counts
    shapes/ renders/ scans/ operators/ maps/    <key>.npz: the result; <key>.json: its record
    scores/<key>.json failures/<key>.json
    table.parquet, table.csv, failures.csv      merged

A result counts as done if its ``.json`` can be read and its ``.npz`` has the size noted there, so a file
that was cut short is simply made again. The record holds settings, keys of inputs, versions of libraries,
time and memory.
"""

import json
import os
import platform
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from datasets_gen import Collection, InputError
from datasets_gen.fingerprints import library_versions
from datasets_gen.records import atomic_path
from evaluation.experiment.tasks import STAGES, Task
from evaluation.results.outcome import Outcome

if TYPE_CHECKING:
    import pandas as pd

    from medial import Diffusion, Matching
    from scanner_sim import Scan

FORMAT = 2
"""Of the files in a results folder. Another one than `READABLE` is refused with one line."""
READABLE = (1, 2)
"""Formats that can be read. In format 1, ``mirror_check`` is called ``flip_decision`` and has other words."""
FORMAT_1_WORDS = {"kept": "agrees", "flipped": "overruled"}
FOLDERS = {
    "shape": "shapes",
    "render": "renders",
    "scan": "scans",
    "operator": "operators",
    "map": "maps",
    "score": "scores",
}
TIMING = ("seconds_operator", "seconds_match", "peak_memory_mb")
"""Columns of the table that differ from run to run."""


class ResultsStore:
    """A results folder, for reading; a run writes through it.

    Parameters
    ----------
    folder
        Made by `evaluation.run`.

    Raises
    ------
    InputError
        If the folder holds results of another format.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)
        found = self.run_info().get("format", FORMAT)
        if found not in READABLE:
            raise InputError(
                f"{str(folder)!r} holds results of format {found!r}, this version reads {FORMAT}; "
                "use another folder, or the version that made it"
            )

    # ------------------------------------------------------------------ reading

    def run_info(self) -> dict[str, Any]:
        """Versions, machine, wall time and counts of the last run; empty before the first."""
        try:
            return dict(json.loads((self.folder / "run.json").read_text(encoding="utf-8")))
        except (FileNotFoundError, NotADirectoryError):
            return {}
        except (OSError, ValueError) as error:
            raise InputError(
                f"{str(self.folder / 'run.json')!r} is not readable ({error}); remove it"
            ) from error

    def table(self) -> "pd.DataFrame":
        """The merged table, one row per score.

        Raises
        ------
        InputError
            If there is none.
        """
        import pandas as pd

        path = self.folder / "table.parquet"
        if not path.is_file():
            raise InputError(f"{str(self.folder)!r} holds no results table; run `medialbench run` first")
        try:
            table = pd.read_parquet(path)
        except (OSError, ValueError) as error:
            raise InputError(f"{str(path)!r} is not readable ({error}); run the experiment again") from error
        if "flip_decision" in table:
            table = table.rename(columns={"flip_decision": "mirror_check"})
            table["mirror_check"] = table["mirror_check"].replace(FORMAT_1_WORDS)
        return table

    def failures(self) -> "pd.DataFrame":
        """Tasks of the last run that have no result: key, stage, label, kind, reason."""
        import pandas as pd

        path = self.folder / "failures.csv"
        columns = ["key", "stage", "label", "kind", "reason"]
        return pd.read_csv(path, keep_default_na=False) if path.is_file() else pd.DataFrame(columns=columns)

    def scan(self, key: str) -> "Scan":
        """A stored cloud."""
        from scanner_sim import Scan

        return Scan.load(self.path("scan", key))

    def operator(self, key: str) -> "Diffusion":
        """A stored operator."""
        from medial import Diffusion

        return Diffusion.load(self.path("operator", key))

    def matching(self, key: str) -> "Matching":
        """A stored correspondence."""
        from medial import Matching

        return Matching.load(self.path("map", key))

    def score(self, key: str) -> dict[str, Any]:
        """What a score task found: ``row`` and, for maps, ``curve``."""
        record = self.record("score", key)
        if record is None:
            raise InputError(f"{str(self.folder)!r} holds no score {key!r}")
        return dict(record["info"])

    def collection(self, dataset: str) -> Collection:
        """The shapes of a data set as they were used, by the name in the table's column ``dataset``."""
        keys = self.run_info().get("datasets", {})
        if dataset not in keys:
            raise InputError(f"{str(self.folder)!r} has no data set {dataset!r}; it has {sorted(keys)}")
        return Collection.load(self.path("shape", keys[dataset]))

    @cached_property
    def settings(self) -> dict[str, Any]:
        """The experiment as run, parsed from ``experiment.toml``."""
        import tomllib

        try:
            return tomllib.loads((self.folder / "experiment.toml").read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise InputError(f"{str(self.folder)!r} has no readable experiment.toml ({error})") from error

    # ------------------------------------------------------------------ tasks

    def path(self, stage: str, key: str) -> Path:
        """File of a result."""
        return self.folder / FOLDERS[stage] / f"{key}{'.json' if stage == 'score' else '.npz'}"

    def record(self, stage: str, key: str) -> dict[str, Any] | None:
        """What is noted of a result that is there and whole: seconds, memory, info; None otherwise."""
        note = self.folder / FOLDERS[stage] / f"{key}.json"
        try:
            record = json.loads(note.read_text(encoding="utf-8"))
            size = None if stage == "score" else self.path(stage, key).stat().st_size
        except (OSError, ValueError):
            return None
        return record if isinstance(record, dict) and record.get("bytes") == size else None

    def write_record(
        self, task: Task, seconds: float, cpu_seconds: float, memory_mb: float | None, info: Mapping[str, Any]
    ) -> None:
        """Note a finished task; its file, if it has one, is in place already. Clears an earlier failure.

        Parameters
        ----------
        task
        seconds, cpu_seconds
            Of computing and storing.
        memory_mb
            Peak memory of the process meanwhile; None if unknown.
        info
            What the stage found, besides its file.
        """
        size = None if task.stage == "score" else self.path(task.stage, task.key).stat().st_size
        record = {
            "key": task.key,
            "stage": task.stage,
            "label": task.label,
            "spec": task.spec,
            "inputs": task.inputs,
            "versions": {"python": platform.python_version(), **library_versions(STAGES[task.stage])},
            "seconds": seconds,
            "cpu_seconds": cpu_seconds,
            "peak_memory_mb": memory_mb,
            "bytes": size,
            "info": info,
        }
        write_json(self.folder / FOLDERS[task.stage] / f"{task.key}.json", record)
        (self.folder / "failures" / f"{task.key}.json").unlink(missing_ok=True)

    def write_failure(self, outcome: Outcome) -> None:
        """Note why a task has no result. Failures are never taken for results: the next run tries again."""
        task = outcome.task
        note: dict[str, Any] = {
            "key": task.key,
            "stage": task.stage,
            "label": task.label,
            "kind": outcome.kind,
        }
        note |= {"reason": outcome.reason, "detail": outcome.detail, "spec": task.spec, "inputs": task.inputs}
        write_json(self.folder / "failures" / f"{task.key}.json", note)


def write_json(path: Path, value: Any) -> None:
    """Write JSON atomically."""
    with atomic_path(path) as temporary:
        temporary.write_text(json.dumps(value, indent=1) + "\n", encoding="utf-8")

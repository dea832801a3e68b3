"""The results folder: every result on its own, written under a temporary name and renamed.

::

    experiment.toml   the experiment, every setting spelled out
    run.json          versions, machine, wall time, counts
    shapes/ renders/ scans/ operators/ maps/    <key>.npz: the result; <key>.json: its record
    scores/<key>.json failures/<key>.json
    table.parquet, table.csv, failures.csv      merged

A result counts as done if its ``.json`` and its ``.npz`` have the checksums noted in the former; a run makes
what is damaged again. Results of earlier versions have no checksums: there the size and the archive's own
checksums count. The record holds settings, keys of inputs, versions of libraries, time and memory.
"""

import contextlib
import json
import os
import platform
from collections.abc import Mapping
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from datasets_gen import Collection, InputError
from datasets_gen.collections.folder import code_version
from datasets_gen.fingerprints import library_versions
from datasets_gen.parsing import parsed_toml
from datasets_gen.records import atomic_path, file_content, leftovers
from evaluation.experiment.tasks import STAGES, Task
from evaluation.results.integrity import checksum, sealed, unsealed
from evaluation.results.outcome import Outcome
from evaluation.results.result_files import FOLDERS, ResultFiles

if TYPE_CHECKING:
    import pandas as pd

    from medial import Diffusion, Matching
    from scanner_sim import Scan

FORMAT = 2
"""Of the files in a results folder. Another one than `READABLE` is refused with one line."""
READABLE = (1, 2)
"""Formats that can be read. In format 1, ``mirror_check`` is called ``flip_decision`` and has other words."""
FORMAT_1_WORDS = {"kept": "agrees", "flipped": "overruled"}
MERGED = ("table.parquet", "table.csv", "failures.csv", "experiment.toml")
"""Files of a finished run, whose checksums are in ``run.json``."""
IDENTIFYING = (
    *("kind", "dataset", "method", "operator", "regime", "views", "seed", "source_threshold"),
    *("source_pose", "target_pose"),
)
"""Columns without which the rows of a table mean nothing; versions differ in the others."""
TIMING = ("seconds_operator", "seconds_match", "peak_memory_mb")
"""Columns of the table that differ from run to run."""


class ResultsStore(ResultFiles):
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
        super().__init__(folder)
        found = self.last_run().get("format", FORMAT)
        if found not in READABLE:
            raise InputError(
                f"{str(folder)!r} holds results of format {found!r}, this version reads {FORMAT}; "
                "use another folder, or the version that made it"
            )

    # ------------------------------------------------------------------ reading

    def run_info(self) -> dict[str, Any]:
        """Versions, machine, wall time and counts of the last run; empty before the first."""
        info = self.last_run()
        if not info and (self.folder / "run.json").exists():
            raise self.damaged("run.json")
        return info

    def last_run(self) -> dict[str, Any]:
        """As `run_info`, but empty if ``run.json`` is damaged: a run writes it again."""
        try:
            return unsealed(self.folder / "run.json")
        except (OSError, ValueError):
            return {}

    def merged_files(self) -> dict[str, int]:
        """Checksums of the files of a finished run that are there."""
        paths = {name: self.folder / name for name in MERGED}
        return {name: checksum(path) for name, path in paths.items() if path.is_file()}

    def is_merged(self) -> bool:
        """Whether all files of a finished run are there as they were written."""
        noted = self.last_run().get("files")
        return noted == self.merged_files() and set(MERGED) <= set(noted)

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
        if self.last_run().get("files", {}).get(path.name, known := checksum(path)) != known:
            raise self.damaged(path.name)
        try:
            table = pd.read_parquet(path)
        except Exception as error:  # a broken file makes its reader raise anything
            raise self.damaged(path.name, error) from error
        lacking = [name for name in IDENTIFYING if name not in table]
        if lacking:
            raise self.damaged(path.name, ValueError(f"it lacks the column {lacking[0]!r}"))
        if "flip_decision" in table:
            table = table.rename(columns={"flip_decision": "mirror_check"})
            table["mirror_check"] = table["mirror_check"].replace(FORMAT_1_WORDS)
        return table

    def failures(self) -> "pd.DataFrame":
        """Tasks of the last run that have no result: key, stage, label, kind, reason."""
        import pandas as pd

        path = self.folder / "failures.csv"
        columns = ["key", "stage", "label", "kind", "reason"]
        if not path.is_file():
            return pd.DataFrame(columns=columns)
        try:
            return pd.read_csv(path, keep_default_na=False)[columns]
        except (ValueError, KeyError) as error:
            raise self.damaged(path.name, error) from error

    def scan(self, key: str) -> "Scan":
        """A stored cloud."""
        from scanner_sim import Scan

        return Scan.load(self.whole_path("scan", key))

    def operator(self, key: str) -> "Diffusion":
        """A stored operator."""
        from medial import Diffusion

        return Diffusion.load(self.whole_path("operator", key))

    def matching(self, key: str) -> "Matching":
        """A stored correspondence."""
        from medial import Matching

        return Matching.load(self.whole_path("map", key))

    def score(self, key: str) -> dict[str, Any]:
        """What a score task found: ``row`` and, for maps, ``curve``."""
        record = self.record("score", key)
        if record is None:
            raise InputError(
                f"{str(self.folder)!r} holds no score {key!r}, which its table names; the run's command "
                "makes it again"
            )
        return dict(record["info"])

    def collection(self, dataset: str) -> Collection:
        """The shapes of a data set as they were used, by the name in the table's column ``dataset``."""
        keys = self.run_info().get("datasets", {})
        if dataset not in keys:
            raise InputError(f"{str(self.folder)!r} has no data set {dataset!r}; it has {sorted(keys)}")
        return self.shape(str(keys[dataset]))

    def shape(self, key: str) -> Collection:
        """The shapes of a stored data set."""
        return Collection.load(self.whole_path("shape", key))

    @cached_property
    def settings(self) -> dict[str, Any]:
        """The experiment as run, parsed from ``experiment.toml``."""
        path = self.folder / "experiment.toml"
        try:
            return parsed_toml(file_content(path), repr(str(path)))
        except OSError as error:
            raise InputError(f"{str(self.folder)!r} has no readable experiment.toml ({error})") from error

    # ------------------------------------------------------------------ tasks

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
        path = None if task.stage == "score" else self.path(task.stage, task.key)
        record = {
            "key": task.key,
            "stage": task.stage,
            "label": task.label,
            "spec": task.spec,
            "inputs": task.inputs,
            "versions": dict(_versions(STAGES[task.stage])),
            "seconds": seconds,
            "cpu_seconds": cpu_seconds,
            "peak_memory_mb": memory_mb,
            "bytes": path.stat().st_size if path else None,
            "file_checksum": checksum(path) if path else None,
            "info": info,
        }
        write_json(self.file(task.stage, task.key, ".json"), sealed(record))
        (self.folder / "failures" / f"{task.key}.json").unlink(missing_ok=True)

    def remove_leftovers(self) -> None:
        """Remove what killed runs have left: temporary files, and notes of tasks that ran.

        Only for who holds the folder's lock.
        """
        found = [
            each for name in ("", "failures", *FOLDERS.values()) for each in leftovers(self.folder / name)
        ]
        for path in [*found, *(self.folder / "running").glob("*")]:
            with contextlib.suppress(OSError):
                path.unlink()

    def write_run_info(self, info: Mapping[str, Any]) -> None:
        """Write ``run.json``, the last file of a run, with checksums of those that were merged before it."""
        write_json(self.folder / "run.json", sealed({**info, "files": self.merged_files()}))

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


@cache
def _versions(module: str) -> dict[str, str]:
    """Of Python, of this program and of the libraries that a stage's module computes with."""
    own = {"python": platform.python_version(), "medialbench": code_version()}
    return own | library_versions(module)


def write_json(path: Path, value: Any) -> None:
    """Write JSON atomically."""
    with atomic_path(path) as temporary:
        temporary.write_text(json.dumps(value, indent=1) + "\n", encoding="utf-8")

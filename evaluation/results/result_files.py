"""Files of single results: where they are, and whether they are what was written."""

import os
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from datasets_gen.paths import inside
from datasets_gen.records import InputError
from evaluation.experiment.tasks import Task
from evaluation.results.integrity import checksum, damage_of_archive, unsealed

FOLDERS = {
    "shape": "shapes",
    "render": "renders",
    "scan": "scans",
    "operator": "operators",
    "map": "maps",
    "score": "scores",
}
RECORD = (
    "key",
    "stage",
    "label",
    "spec",
    "inputs",
    "versions",
    "seconds",
    "cpu_seconds",
    "peak_memory_mb",
    "bytes",
    "info",
)
"""Entries of records of earlier versions."""
READERS = 8
"""Threads that compare checksums."""


class ResultFiles:
    """The files of a results folder, by stage and key.

    Parameters
    ----------
    folder
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)

    def path(self, stage: str, key: str) -> Path:
        """File of a result; InputError if the key, which may come from a table, is no name of a file."""
        return self.file(stage, key, ".json" if stage == "score" else ".npz")

    def file(self, stage: str, key: str, suffix: str) -> Path:
        """File of that suffix that belongs to a result; InputError as `path`."""
        if not key or key.startswith(".") or not {"/", "\\", "\0"}.isdisjoint(key):
            raise InputError(f"{str(self.folder)!r} names a result {key!r}, which is no key; run it again")
        return self.folder / FOLDERS[stage] / f"{key}{suffix}"

    def whole_path(self, stage: str, key: str) -> Path:
        """File of a result, to be read.

        Raises
        ------
        InputError
            If it is damaged, or is a link to a place outside the folder.
        """
        path = inside(self.path(stage, key).parent, self.path(stage, key).name, "result")
        why = self._damage(stage, key, self.record(stage, key))
        if why:
            raise self.damaged(f"{FOLDERS[stage]}/{path.name}", why)
        return path

    def examined(self, tasks: Iterable[Task]) -> tuple[set[str], dict[str, str]]:
        """Keys of tasks whose results are there and whole, every byte compared; and what is damaged.

        Returns
        -------
        keys : set of str
        damaged : dict of str to str
            What is wrong, by the result's file within the folder.
        """
        stored, damaged = set(), {}
        tasks = list(tasks)
        with ThreadPoolExecutor(READERS) as pool:
            for task, (there, why) in zip(tasks, pool.map(self._examine, tasks), strict=True):
                if why:
                    damaged[f"{FOLDERS[task.stage]}/{self.path(task.stage, task.key).name}"] = why
                elif there:
                    stored.add(task.key)
        return stored, damaged

    def _examine(self, task: Task) -> tuple[bool, str]:
        """Whether a result is there, and what is wrong with it."""
        if not self.file(task.stage, task.key, ".json").exists():
            return False, ""
        record = self.record(task.stage, task.key)
        return True, self._damage(task.stage, task.key, record)

    def _damage(self, stage: str, key: str, record: Mapping[str, Any] | None) -> str:
        path = self.path(stage, key)
        if record is None:
            return "its record or its size is another one" if path.is_file() else "its file is missing"
        if stage == "score":
            return ""
        if "file_checksum" not in record:  # of an earlier version
            return damage_of_archive(path)
        try:
            same = checksum(path) == record["file_checksum"]
        except OSError as error:
            return error.strerror or str(error)
        return "" if same else "its checksum is another one"

    def record(self, stage: str, key: str) -> dict[str, Any] | None:
        """What is noted of a result that is there: seconds, memory, info; None otherwise, or if damaged.

        Of the result's file only the size is compared; `examined` and `whole_path` compare every byte.
        """
        try:
            record = unsealed(self.file(stage, key, ".json"), RECORD)
            size = None if stage == "score" else self.path(stage, key).stat().st_size
        except (OSError, ValueError):
            return None
        return record if (record.get("key"), record.get("bytes")) == (key, size) else None

    def damaged(self, name: str, why: object = "its checksum is another one") -> InputError:
        """What is said of a file that is not as it was written."""
        again, reason = f"medialbench run {self.folder}", " ".join(str(why).split())
        return InputError(f"{str(self.folder / name)!r} is damaged ({reason}); {again} makes it again")

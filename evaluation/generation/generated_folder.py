"""The folder of generated training data: its files, whether they are whole, and whether they belong to it.

::

    train-000000.tar, ..., val-000000.tar, ...   shards
    references/NAME.npz      the mesh that face ids and barycentric coordinates of a data set are about
    samples.csv              a line per sample: shard, body, pose, threshold, missing share
    failures.csv             samples and shards that are missing, and why
    dataset.json, DATASHEET.md   settings, versions, checksums, statistics, terms: for programs and for people
    generation.json          what is made here, written first
    notes/NAME.json          checksum and statistics of a shard or a reference, written after it

A shard counts as made if its note has the key of the task and the SHA-256 of the file.
"""

import contextlib
import hashlib
import re
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from datasets_gen.records import InputError, leftovers
from evaluation.experiment.tasks import Task
from evaluation.results.integrity import sealed, unsealed
from evaluation.results.store import write_json

FORMAT = 1
STATE = "generation.json"
SUMMARY = ("dataset.json", "DATASHEET.md", "samples.csv", "failures.csv")
SHARD = re.compile(r"(train|val)-\d{6}\.tar")
READERS = 4
"""Threads that compare checksums."""
CHUNK = 1 << 20


class GeneratedFolder:
    """The folder, for those who write it.

    Parameters
    ----------
    path
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def file_of(self, task: Task) -> Path:
        """File that a task makes."""
        return self.path / str(task.spec["file"])

    def note_path(self, task: Task) -> Path:
        """Note about the file that a task makes."""
        return self.path / "notes" / f"{Path(task.spec['file']).stem}-{task.stage}.json"

    def write_note(self, task: Task, facts: Mapping[str, Any]) -> None:
        """Note that a task's file is as it has to be."""
        path = self.file_of(task)
        note = {"key": task.key, "file": task.spec["file"], "bytes": path.stat().st_size}
        write_json(self.note_path(task), sealed({**note, "sha256": sha256(path), **facts}))

    def note(self, task: Task) -> dict[str, Any] | None:
        """The note about a task's file; None if there is none, it is damaged or is about another task."""
        try:
            found = unsealed(self.note_path(task))
        except (OSError, ValueError):
            return None
        return found if found.get("key") == task.key else None

    def examined(self, tasks: Iterable[Task]) -> tuple[set[str], dict[str, str]]:
        """Keys of tasks whose files are whole, every byte compared; and what is wrong with damaged ones."""
        tasks = list(tasks)
        with ThreadPoolExecutor(READERS) as pool:
            found = dict(zip([task.key for task in tasks], pool.map(self._examine, tasks), strict=True))
        damaged = {str(task.spec["file"]): why for task in tasks if (why := found[task.key])}
        return {key for key, why in found.items() if why == ""}, damaged

    def _examine(self, task: Task) -> str | None:
        """What is wrong with a task's file; empty if nothing, None if it has to be made anyway."""
        note = self.note(task)
        if note is None or note.get("again"):
            return None
        try:
            return "" if sha256(self.file_of(task)) == note["sha256"] else "its checksum is another one"
        except OSError as error:
            return error.strerror or str(error)

    def state(self) -> dict[str, Any] | None:
        """What is made here; None in a new folder.

        Raises
        ------
        InputError
            If it is damaged, or the folder has shards and nothing that tells what they are.
        """
        try:
            return unsealed(self.path / STATE)
        except (FileNotFoundError, NotADirectoryError):
            foreign = self.shards()
            if foreign:
                raise InputError(
                    f"{str(self.path)!r} holds {foreign[0]}, which generate did not make; use another folder"
                ) from None
            return None
        except OSError as error:
            reason = error.strerror or str(error)
            raise InputError(
                f"cannot read {str(self.path / STATE)!r}: {reason}; use another folder"
            ) from error
        except ValueError as error:
            raise InputError(
                f"{str(self.path / STATE)!r} is damaged ({error}); --force makes all again"
            ) from error

    def write_state(self, state: Mapping[str, Any]) -> None:
        """Note what is made here."""
        write_json(self.path / STATE, sealed(state))

    def shards(self) -> list[str]:
        """Names of the shards that are there."""
        if not self.path.is_dir():
            return []
        return sorted(each.name for each in self.path.iterdir() if SHARD.fullmatch(each.name))

    def clear(self) -> None:
        """Remove everything that was made here, for ``--force``; other files stay."""
        if not (self.path / STATE).exists():
            self.state()  # raises if there are shards of somebody else
        made = [self.path / name for name in (*self.shards(), *SUMMARY, STATE)]
        made += [*self.path.glob("notes/*.json"), *self.path.glob("references/*.npz")]
        for path in made:
            path.unlink(missing_ok=True)

    def remove_leftovers(self) -> None:
        """Remove what killed runs have left; only for who holds the folder's lock."""
        found = [each for name in ("", "notes", "references") for each in leftovers(self.path / name)]
        for path in [*found, *(self.path / "running").glob("*")]:
            with contextlib.suppress(OSError):
                path.unlink()


def sha256(path: Path) -> str:
    """Hash of a file's bytes, 64 hexadecimal digits."""
    found = hashlib.sha256()
    with path.open("rb") as stream:
        while chunk := stream.read(CHUNK):
            found.update(chunk)
    return found.hexdigest()

"""Notes of started tasks, so that one that takes its process down is noticed and not tried for ever.

Before a task starts, an attempt is noted. A watchdog that needs no interpreter lock ends the process at the
time limit and leaves a dump. Whoever gets the task next finds both.
"""

import faulthandler
import json
import os
from pathlib import Path

from evaluation.experiment.tasks import Task
from evaluation.results.store import write_json

ATTEMPTS = 2
"""Times that a task may take its process down before it counts as failed; a time-out counts at once."""


class Attempt:
    """A context in which a task runs: noted at the start, cleared at the end, ended at the time limit.

    Parameters
    ----------
    folder
        The results folder.
    task
    run
        Name of the run: attempts of earlier runs do not count.
    limit
        Seconds after which the process is ended.
    """

    def __init__(self, folder: Path, task: Task, run: str, limit: float) -> None:
        self._note = folder / "running" / f"{task.key}.json"
        self._dump = folder / "running" / f"{task.key}.txt"
        self._run, self._limit, self._count = run, limit, 0

    def lost(self) -> tuple[str, str, str] | None:
        """Kind, reason and detail if earlier attempts of this run took their process down for good."""
        try:
            note = json.loads(self._note.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        if note.get("run") != self._run:
            return None
        self._count = int(note["attempt"])
        dump = self._dump.read_text(encoding="utf-8") if self._dump.is_file() else ""
        if dump.startswith("Timeout"):
            self.clear()
            return (
                "timeout",
                f"no result after {self._limit:g} s; raise 'timeout' or look at the detail",
                dump,
            )
        if self._count >= ATTEMPTS:
            self.clear()
            return (
                "crash",
                f"took its worker down {self._count} times (killed, out of memory or a fault)",
                dump,
            )
        return None

    def __enter__(self) -> None:
        write_json(self._note, {"run": self._run, "attempt": self._count + 1, "pid": os.getpid()})
        self._stream = self._dump.open("w", encoding="utf-8")
        faulthandler.dump_traceback_later(self._limit, exit=True, file=self._stream)

    def __exit__(self, *_: object) -> None:
        faulthandler.cancel_dump_traceback_later()
        self._stream.close()
        self.clear()

    def clear(self) -> None:
        """Remove the note and the dump."""
        self._note.unlink(missing_ok=True)
        self._dump.unlink(missing_ok=True)

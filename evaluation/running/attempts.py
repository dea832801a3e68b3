"""Notes of started tasks, so that one that takes its process down is noticed and not tried for ever.

Before a task starts, an attempt is noted. A watchdog that needs no interpreter lock ends the process at the
time limit and leaves a dump; so does a fault. A process has one such watchdog, which a task may take for
itself; then a second one, a plain thread, ends the process a little later. Whoever gets the task next finds
both. One that was running when its process ended may have had bad luck, such as a neighbour that took all
memory: it is tried once more, with no other task beside it.
"""

import contextlib
import faulthandler
import os
import threading
from pathlib import Path

from datasets_gen.parsing import read_note
from datasets_gen.records import cannot_write
from evaluation.experiment.tasks import Task
from evaluation.results.store import write_json

ATTEMPTS = 2
"""Times that a task may take its process down before it counts as failed; a time-out counts at once."""
LATER = 5.0
"""Seconds past the time limit after which the second watchdog ends the process."""
AGAIN = "again"
"""Kind of outcome of a task that has to be tried once more, alone."""


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
    alone
        Whether no other task runs meanwhile.
    """

    def __init__(self, folder: Path, task: Task, run: str, limit: float, alone: bool = False) -> None:
        self._note = folder / "running" / f"{task.key}.json"
        self._dump = folder / "running" / f"{task.key}.txt"
        self._run, self._limit, self._alone, self._count = run, limit, alone, 0

    def lost(self) -> tuple[str, str, str] | None:
        """Kind, reason and detail if earlier attempts of this run took their process down.

        The kind is `AGAIN` if one more attempt is due, alone; None if this attempt can be made.
        """
        note = read_note(self._note, run=str, attempt=int)
        if note is None or note["run"] != self._run:
            return None
        self._count = note["attempt"]
        dump = self._dumped()
        if dump.startswith("Timeout"):
            self.clear()
            return (
                "timeout",
                f"no result after {self._limit:g} s; raise 'timeout' (a first run also compiles, for about a "
                "minute) or look at the detail",
                dump,
            )
        if self._count >= ATTEMPTS:
            self.clear()
            return "crash", _blame(self._count, dump), dump
        return None if self._alone else (AGAIN, "its worker ended; to be tried once more, alone", dump)

    def given_up(self) -> str | None:
        """Why Dask gave up on the task while it ran alone; None if no attempt at it is noted."""
        if not self._note.is_file():
            return None
        reason = _blame(ATTEMPTS, self._dumped())
        self.clear()
        return reason

    def _dumped(self) -> str:
        return self._dump.read_text(encoding="utf-8") if self._dump.is_file() else ""

    def __enter__(self) -> None:
        write_json(self._note, {"run": self._run, "attempt": self._count + 1, "pid": os.getpid()})
        try:
            self._stream = self._dump.open("w", encoding="utf-8")
        except OSError as error:
            self.clear()
            raise cannot_write(self._dump, error) from error
        faulthandler.enable(self._stream)
        faulthandler.dump_traceback_later(self._limit, exit=True, file=self._stream)
        self._second = threading.Timer(min(self._limit + LATER, threading.TIMEOUT_MAX), self._end)
        self._second.daemon = True
        self._second.start()

    def _end(self) -> None:
        with contextlib.suppress(OSError, ValueError):  # whatever the task has done to the dump
            self._dump.write_text("Timeout, and the task has stopped the watchdog\n", encoding="utf-8")
            with self._dump.open("a", encoding="utf-8") as stream:
                faulthandler.dump_traceback(stream)
        os._exit(1)

    def __exit__(self, *_: object) -> None:
        self._second.cancel()
        faulthandler.cancel_dump_traceback_later()
        faulthandler.disable()
        with contextlib.suppress(OSError):  # a method may have closed it
            self._stream.close()
        self.clear()

    def clear(self) -> None:
        """Remove the note and the dump, where the system lets them be removed."""
        for path in (self._note, self._dump):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)


def _blame(times: int, dump: str) -> str:
    fault = dump.splitlines()[0] if dump.startswith("Fatal") else "killed, out of memory or an exit"
    return f"took its worker down {times} times ({fault})"

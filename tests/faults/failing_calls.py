"""Calls of the file system that fail, from the k-th on or the k-th alone.

An audit hook sees what this process asks of the system before the system does. It cannot be removed, so one
hook stays and looks at what is to fail at the moment.
"""

import contextlib
import os
import sys
from dataclasses import dataclass
from pathlib import Path

WRITES = ("open", "os.mkdir", "os.rename", "os.chmod")
REMOVES = ("os.remove",)


@dataclass
class FailingCalls:
    """What is to fail.

    Attributes
    ----------
    folder : Path
        Where; calls for files elsewhere are left alone.
    error : int
        Number of the error.
    first : int
        The first call that fails, counted from 1; 0 if none is to.
    last : int or None
        The last call that fails; None if all that follow fail too.
    events : tuple of str
        Names of the audit events that count: of opening for writing (``"open"``), and others.
    calls : int
        Calls so far.
    failed : int
        Calls that failed.
    """

    folder: Path
    error: int
    first: int = 0
    last: int | None = None
    events: tuple[str, ...] = WRITES
    calls: int = 0
    failed: int = 0

    def called(self, event, args):
        if event not in self.events or not isinstance(args[0], str | os.PathLike):
            return
        if event == "open" and not args[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            return
        path = os.fspath(args[0])
        if not path.startswith(str(self.folder)):
            return
        self.calls += 1
        if self.first and self.first <= self.calls and (self.last is None or self.calls <= self.last):
            self.failed += 1
            raise OSError(self.error, os.strerror(self.error), path)


_now: list[FailingCalls] = []


def _hook(event, args):
    if _now:
        _now[-1].called(event, args)


@contextlib.contextmanager
def failing(calls):
    """A context in which calls fail as told."""
    if not getattr(_hook, "added", False):
        sys.addaudithook(_hook)
        _hook.added = True
    _now.append(calls)
    try:
        yield calls
    finally:
        _now.pop()

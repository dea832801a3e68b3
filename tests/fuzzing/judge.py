"""One case: the reader on one file, within bounds, and what is wrong with what it did; None if nothing is."""

import logging
import os
import resource
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from datasets_gen import InputError
from tests.fuzzing.targets import Target

SECONDS = 5.0
"""Of a processor, so that other work on the machine does not count."""
WAITING = 12.0
"""Time on the clock that a reader may take, relative to that bound: for one that waits."""
MEMORY = 2 << 30
"""Bytes of address space that a reader may take beyond what the process has."""
LONGEST_LINE = 20_000
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_CHANGES = (
    "os.mkdir",
    "os.rename",
    "os.remove",
    "os.rmdir",
    "os.symlink",
    "os.link",
    "os.truncate",
    "shutil.rmtree",
)

_watched: Path | None = None
_strays: list[str] = []
_hooked = False


class TooSlow(BaseException):
    """Past `SECONDS`; no Exception, as readers turn those into InputError."""


def judged(target: Target, data: bytes, folder: Path, seconds: float = SECONDS) -> str | None:
    """What is wrong with how a target reads some bytes; None if nothing is.

    Parameters
    ----------
    target
    data
    folder
        Prepared by `Target.prepare`; the file is written there.
    seconds
        The bound, of processor time.
    """
    path = folder / target.file
    path.write_bytes(data)
    started = time.process_time()
    with _noted_log() as log, _watching(folder), _bounded(seconds), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        problem = _outcome(target, path)
    elapsed = time.process_time() - started
    if problem is None and elapsed > seconds:
        problem = f"took {elapsed:.1f} s"
    if problem is None and _strays:
        problem = f"wrote outside its folder: {_strays[0]}"
    if problem is None and log.tracebacks:
        problem = f"logged a traceback: {log.tracebacks[0]}"
    return problem


def _outcome(target, path):
    try:
        target.check(target.read(path))
    except (InputError, click.UsageError) as error:
        line = error.format_message() if isinstance(error, click.UsageError) else str(error)
        if not line.strip() or len(line.splitlines()) > 1 or len(line) > LONGEST_LINE:
            return f"message of {len(line)} characters is not one line: {line[:300]!r}"
    except TooSlow:
        return "took too long: " + _where(sys.exc_info()[2])
    except Exception as error:
        return f"{type(error).__name__}: {str(error)[:200]} at {_where(error.__traceback__)}"
    return None


def _where(tb) -> str:
    """The last frames of the project, and the last of all."""
    frames = traceback.extract_tb(tb)
    own = [f for f in frames if "site-packages" not in f.filename and "/tests/" not in f.filename] or frames
    return " < ".join(f"{Path(f.filename).name}:{f.name}" for f in [frames[-1], *own[::-1][:3]])


@contextmanager
def _bounded(seconds: float) -> Iterator[None]:
    """TooSlow after a time; MemoryError beyond a size."""

    def late(_signal, _frame):
        raise TooSlow

    timers = {signal.ITIMER_PROF: (signal.SIGPROF, 1.0), signal.ITIMER_REAL: (signal.SIGALRM, WAITING)}
    before = {number: signal.signal(number, late) for number, _ in timers.values()}
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (size + MEMORY, hard))
    for timer, (_, factor) in timers.items():
        signal.setitimer(timer, factor * seconds)
    try:
        yield
    finally:
        for timer in timers:
            signal.setitimer(timer, 0)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _watching(folder: Path) -> Iterator[None]:
    """Note writes outside a folder; bytecode and caches of compiled code do not count."""
    global _watched, _hooked
    if not _hooked:
        sys.addaudithook(_audit)
        _hooked = True
    _strays.clear()
    _watched = folder.resolve()
    try:
        yield
    finally:
        _watched = None


def _audit(event: str, args: tuple) -> None:
    if _watched is None or not (event == "open" or event in _CHANGES):
        return
    if event == "open" and not (isinstance(args[2], int) and args[2] & _WRITING):
        return
    for place in args[: 2 if event in ("os.rename", "os.link", "os.symlink") else 1]:
        if not isinstance(place, str | bytes | os.PathLike):
            continue
        path = os.path.realpath(os.fsdecode(place))
        if not (path.startswith(str(_watched)) or "__pycache__" in path or path.startswith("/dev/")):
            _strays.append(f"{event} {path}")


class _Log(logging.Handler):
    def __init__(self):
        super().__init__()
        self.tracebacks: list[str] = []

    def emit(self, record):
        text = record.getMessage()
        if record.name.partition(".")[0] == "trimesh":  # its messages stay off the terminal
            return
        if record.exc_info or "Traceback (most recent" in text:
            self.tracebacks.append(f"{record.name}: {text[:200]}")


@contextmanager
def _noted_log() -> Iterator[_Log]:
    handler, root = _Log(), logging.getLogger()
    root.addHandler(handler)
    try:
        yield handler
    finally:
        root.removeHandler(handler)

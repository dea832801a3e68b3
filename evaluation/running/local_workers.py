"""Starts Dask's workers on this machine, again where they do not start."""

import contextlib
import logging
import os
import signal
import threading
from collections.abc import Callable, Iterator
from typing import TypeVar

from datasets_gen.records import InputError
from evaluation.results.outcome import one_line

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

log = logging.getLogger(__name__)

T = TypeVar("T")

STARTS = 3
"""Times that workers are started before a run gives up."""

START_WITHIN = 120.0
"""Seconds for all workers to start, the first time; then they are ended, as they may hang."""

SLOWER = 4.0
"""Each further time has so many times as long: the machine may be busy."""

FILES, FILES_PER_WORKER = 64, 16
"""Open files and connections of a run with local workers; 25 and 10.5 were counted."""


def start_workers(make: Callable[[], T]) -> T:
    """What `make` gives, which starts worker processes; tried again if one of them ends or hangs meanwhile.

    Raises
    ------
    InputError
        If they do not start.
    """
    reason = ""
    for attempt in range(STARTS):
        try:
            with _ended_after(START_WITHIN * SLOWER**attempt):
                return make()
        except (RuntimeError, OSError) as error:  # of Dask; a TimeoutError is the latter
            reason = one_line(error.__cause__ or error)
            log.info("the workers do not start: %s", reason)
    raise InputError(f"the workers on this machine do not start ({reason}); try fewer of them (--jobs)")


@contextlib.contextmanager
def _ended_after(seconds: float) -> Iterator[None]:
    """A context that ends, after some time, all processes that began in it: Dask would wait for ever."""
    import psutil  # Dask needs it

    this = psutil.Process()
    before = {child.pid for child in this.children()}

    def end() -> None:
        for child in this.children():
            if child.pid not in before:
                kill_process(child.pid)

    timer = threading.Timer(seconds, end)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def kill_process(process: int | None) -> None:
    """End a process of this user at once, if it is there."""
    if process is not None:
        with contextlib.suppress(OSError):
            os.kill(process, getattr(signal, "SIGKILL", signal.SIGTERM))  # Windows has the latter alone


def allow_open_files(workers: int) -> None:
    """Let this process have the open files that a run needs, where the system knows such a limit.

    Parameters
    ----------
    workers
        On this machine.

    Raises
    ------
    InputError
        If its hard limit is too low.
    """
    if resource is None:
        return
    needed = FILES + FILES_PER_WORKER * workers
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft >= needed or soft == resource.RLIM_INFINITY:
        return
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (needed, hard))
    except (OSError, ValueError) as error:
        raise InputError(
            f"only {hard} files may be open at once, {workers} workers need {needed}; raise the limit "
            "(ulimit -Hn) or use fewer workers (--jobs)"
        ) from error

"""Starts and ends Dask's workers on this machine, whether or not they do."""

import contextlib
import logging
import os
import signal
import threading
from collections.abc import Callable, Iterator, Set
from typing import Any, TypeVar

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

CLOSE_WITHIN = 30.0
"""Seconds after which workers are ended that do not end by themselves."""

FILES, FILES_PER_WORKER = 64, 16
"""Open files and connections of a run with local workers; 25 and 10.5 were counted."""


@contextlib.contextmanager
def local_cluster(make: Callable[[], T]) -> Iterator[T]:
    """A context with the cluster that `make` starts; none of its processes is left afterwards.

    Parameters
    ----------
    make
        Gives a cluster, when its workers have started.

    Raises
    ------
    InputError
        If they do not start.
    """
    before = _children()
    cluster = _started(make, before)
    try:
        yield cluster
    finally:
        _close(cluster, before)


def _started(make: Callable[[], T], before: Set[int]) -> T:
    """The cluster; tried again if a worker ends or hangs as it starts, for which Dask would wait for ever."""
    reason = ""
    for attempt in range(STARTS):
        timer = threading.Timer(START_WITHIN * SLOWER**attempt, _end_children, [before])
        timer.daemon = True
        timer.start()
        try:
            return make()
        except (RuntimeError, OSError) as error:  # of Dask; a TimeoutError is the latter
            reason = one_line(error.__cause__ or error)
            log.info("the workers do not start: %s", reason)
        finally:
            timer.cancel()
    raise InputError(f"the workers on this machine do not start ({reason}); try fewer of them (--jobs)")


def _close(cluster: Any, before: Set[int]) -> None:
    """Close a cluster, by force if it takes long: Dask would wait for ever for a worker that hangs."""
    for _ in range(2):
        try:
            cluster.close(timeout=CLOSE_WITHIN)
            return
        except (TimeoutError, AssertionError):  # the latter of Dask, about workers that have not ended
            _end_children(before)


def _children() -> set[int]:
    import psutil  # Dask needs it

    return {child.pid for child in psutil.Process().children()}


def _end_children(before: Set[int]) -> None:
    """End at once all processes of this one that began later."""
    for process in _children() - before:
        kill_process(process)


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

"""Settings and measurements of the process that runs a task: threads, Ctrl-C, allocator, peak memory."""

import contextlib
import ctypes
import functools
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from multiprocessing import resource_tracker
from pathlib import Path
from types import FrameType

SAFE_PATH = "medialbench"
"""``PYTHONSAFEPATH`` of a worker while it starts: it imports nothing from the current folder."""


def forget_safe_path() -> None:
    """Let what a task starts import what lies beside its script: the setting was for this process alone."""
    if os.environ.get("PYTHONSAFEPATH") == SAFE_PATH:
        del os.environ["PYTHONSAFEPATH"]


@contextlib.contextmanager
def hold_interrupts() -> Iterator[None]:
    """Hear Ctrl-C when the block ends; processes that start in it, and those that these start, never do.

    A terminal sends it to all processes, but the run alone has to act on it: it ends its workers.
    """
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "pthread_sigmask"):
        yield  # Windows; or a thread, which no signal reaches
        return
    resource_tracker.ensure_running()  # it would let the signal through to what starts after it
    heard: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: heard.append(number))
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        signal.signal(signal.SIGINT, before)
    if heard:
        raise KeyboardInterrupt


@contextlib.contextmanager
def polled_interrupts(wake: Callable[[], object] = lambda: None) -> Iterator[Callable[[], None]]:
    """Ctrl-C that is raised where the block asks for it, and at its end.

    Raised anywhere it can be lost: Python prints and ignores what is raised in a finalizer, such as that of
    Dask's futures, and the run would go on. Pressed again it is raised at once.

    Parameters
    ----------
    wake
        Called when Ctrl-C is pressed, to end a wait. It must be safe in a signal handler.

    Yields
    ------
    callable
        Raises KeyboardInterrupt if Ctrl-C was pressed.
    """
    heard: list[int] = []

    def check() -> None:
        if heard:
            raise KeyboardInterrupt

    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield check  # a thread, which no signal reaches; or a process that ignores it
        return

    def hear(number: int, frame: FrameType | None) -> None:
        check()
        heard.append(number)
        wake()

    signal.signal(signal.SIGINT, hear)
    try:
        yield check
    finally:
        signal.signal(signal.SIGINT, before)
    check()


@contextlib.contextmanager
def single_thread() -> Iterator[None]:
    """One thread for BLAS and OpenMP: tasks run side by side, and results must not depend on how many."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield


@functools.cache
def keep_freed_memory() -> None:
    """Let the allocator keep what is freed: Dask's nanny asks it to give back everything at once.

    With Dask's setting (``MALLOC_TRIM_THRESHOLD_=65536``) a match spent a third of its time in page faults.
    Nothing happens where the C library is not glibc.
    """
    if not sys.platform.startswith("linux"):
        return
    trim_threshold, mmap_threshold = -1, -3  # names of malloc.h
    with contextlib.suppress(OSError, AttributeError, TypeError):
        mallopt = ctypes.CDLL(None).mallopt
        mallopt(trim_threshold, 512 << 20)
        mallopt(mmap_threshold, 32 << 20)


class PeakMemory:
    """Filled when the block of `peak_memory` ends.

    Attributes
    ----------
    megabytes : float or None
        None where the system does not tell.
    """

    megabytes: float | None = None


@contextlib.contextmanager
def peak_memory() -> Iterator[PeakMemory]:
    """Largest resident memory of this process within a block, where the system can tell (Linux)."""
    found = PeakMemory()
    try:
        Path("/proc/self/clear_refs").write_text("5", encoding="utf-8")  # resets the high-water mark
        resets = True
    except OSError:
        resets = False
    yield found
    if resets:
        for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
            if line.startswith("VmHWM:"):
                found.megabytes = int(line.split()[1]) / 1024

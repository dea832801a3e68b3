"""Compiling and running the package's kernels: cached machine code, plain threads.

Kernels are compiled without the interpreter lock and split over our own threads. That keeps results
independent of the number of threads (each task owns its outputs), is safe under ``fork`` and inside Dask
workers, and compiles several times faster than automatic parallelisation.
"""

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import Any, TypeVar

import numba
import numpy as np

T = TypeVar("T")


def compiled(inline: str = "never") -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """`numba.njit` without the interpreter lock, cached on disk where any cache folder can be written.

    Arithmetic is that of IEEE 754 in the order written, so that a kernel has the same bits on every
    processor. With ``fastmath`` the compiler chooses the order, and does not always choose the same: one
    function compiled before or after others had other last digits.

    Numba caches beside the module, else in the user's cache folder. With neither writable it refuses; then
    the kernel is compiled once per process.
    """

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        settings: dict[str, Any] = {"nogil": True, "error_model": "numpy", "inline": inline}
        try:
            return numba.njit(cache=True, **settings)(function)
        except RuntimeError:
            return numba.njit(**settings)(function)

    return decorate


@compiled()
def grown(array: Any) -> Any:
    """A copy of a one-dimensional array with room for twice as many values."""
    larger = np.empty(2 * len(array), array.dtype)
    for k in range(len(array)):
        larger[k] = array[k]
    return larger


def thread_count() -> int:
    """Threads a kernel may use: the least of our processors, NUMBA_NUM_THREADS and OMP_NUM_THREADS.

    Dask sets OMP_NUM_THREADS to 1 in its workers, so a sweep does not oversubscribe the machine.
    """
    count = int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]
    limit = os.environ.get("OMP_NUM_THREADS", "").split(",")[0]
    return max(1, min(count, int(limit))) if limit.isdigit() else count


def run_tasks(function: Callable[..., T], arguments: Sequence[tuple[Any, ...]]) -> list[T]:
    """Call ``function(*a)`` for every ``a``, on `thread_count` threads; results in the order given.

    Called from within a task, it does the work in that task's thread.
    """
    threads = min(thread_count(), len(arguments))
    if threads <= 1 or getattr(_worker, "busy", False):
        return [function(*each) for each in arguments]
    return list(_pool(os.getpid(), thread_count()).map(lambda each: function(*each), arguments))


_worker = threading.local()


@lru_cache(maxsize=4)
def _pool(process: int, threads: int) -> ThreadPoolExecutor:
    """Threads of this process, started when first needed: a forked child must not wait for its parent's."""
    return ThreadPoolExecutor(threads, f"medial-{process}", initializer=_enter)


def _enter() -> None:
    _worker.busy = True


def ranges(n: int, size: int) -> list[tuple[int, int]]:
    """``[0, n)`` in pieces of at most `size`: the split never depends on the number of threads."""
    return [(start, min(start + size, n)) for start in range(0, n, size)]

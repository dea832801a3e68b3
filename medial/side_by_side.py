"""Two long calls at once, whose messages stay in order."""

import logging
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

from medial.device.backend import CPU
from medial.matching.nearest import single_blas_thread

T = TypeVar("T")

PACKAGES = ("datasets_gen", "scanner_sim", "medial", "evaluation", "reports")
"""Whose messages are kept in order."""


def side_by_side(
    function: Callable[..., T], first: tuple[Any, ...], second: tuple[Any, ...], device: str = CPU
) -> tuple[T, T]:
    """Call a function with both arguments; what it logs of the second comes after what it logs of the first.

    The calls share the threads of the kernels: what one does alone, as small matrix products, the other fills
    with work. Where both fail, the error of the first is raised. On another `device` than the processor they
    run one after the other.
    """
    if device != CPU:
        return function(*first), function(*second)
    held = _HeldMessages()
    with single_blas_thread(), ThreadPoolExecutor(1, initializer=held.begin) as pool:
        later = pool.submit(function, *second)
        try:
            result = function(*first)
        finally:
            try:
                later.exception()  # waits
            finally:
                held.release()
    return result, later.result()


class _HeldMessages(logging.Filter):
    """Holds back what a thread logs until it is released."""

    def __init__(self) -> None:
        super().__init__()
        self._thread: int | None = None
        self._records: list[logging.LogRecord] = []

    def begin(self) -> None:
        """Hold what this thread logs from here on."""
        self._thread = threading.get_ident()
        for logger in _loggers():
            logger.addFilter(self)

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether the record goes on now."""
        if record.thread != self._thread:
            return True
        self._records.append(record)
        return False

    def release(self) -> None:
        """Log what was held back; filters that were there before have seen it."""
        for logger in _loggers():
            logger.removeFilter(self)
        for record in self._records:
            logging.getLogger(record.name).callHandlers(record)


def _loggers() -> list[logging.Logger]:
    """Those of the packages' modules; a filter is not inherited."""
    known = dict(logging.root.manager.loggerDict)
    own = [each for name, each in known.items() if name.split(".")[0] in PACKAGES]
    return [each for each in own if isinstance(each, logging.Logger)]

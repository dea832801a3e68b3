"""Warnings of this project's packages while a task runs: its outcome has them, and the driver says them."""

import contextlib
import logging
from collections.abc import Iterator

from evaluation.results.outcome import Outcome, printable

PACKAGES = ("datasets_gen", "scanner_sim", "medial")
MOST = 20
"""Warnings of a task that are kept."""


class _Kept(logging.Handler):
    """Keeps the first warnings as (logger, message)."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.said: list[tuple[str, str]] = []

    def emit(self, record: logging.LogRecord) -> None:
        if len(self.said) < MOST:
            self.said.append((record.name, printable(record.getMessage())))


@contextlib.contextmanager
def gathered_warnings() -> Iterator[list[tuple[str, str]]]:
    """Gather warnings of the packages, as (logger, message), instead of printing them."""
    handler, loggers = _Kept(), [logging.getLogger(name) for name in PACKAGES]
    passed_on = [each.propagate for each in loggers]
    for each in loggers:
        each.addHandler(handler)
        each.propagate = False
    try:
        yield handler.said
    finally:
        for each, before in zip(loggers, passed_on, strict=True):
            each.removeHandler(handler)
            each.propagate = before


def repeat_warnings(outcome: Outcome) -> None:
    """Log what a task warned of, under the names it had there."""
    for name, message in outcome.warnings:
        logging.getLogger(name).warning("%s", message)

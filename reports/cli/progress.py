"""Progress of all commands and of sweeps: a bar on a terminal, lines at intervals elsewhere."""

import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from reports.cli.console import error_console, say

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress

    from evaluation.results.outcome import Outcome
    from evaluation.running.progress import Forecast, ProgressCallbacks

SECONDS_PER_LINE = 15.0
"""Seconds between progress lines where the output is no terminal."""


class ProgressBar:
    """Progress over weighted work.

    The estimate of the time that remains falls while a step runs, on a terminal and in lines.

    Parameters
    ----------
    total
        Amount of work, in any unit.
    description
        What is being done now.
    quiet
        Show nothing.
    remaining
        Seconds that remain, where the caller knows better than the mean speed so far.
    """

    def __init__(
        self, total: float, description: str, quiet: bool, remaining: Callable[[], float] | None = None
    ) -> None:
        self._total, self._done, self._quiet = total, 0.0, quiet
        self._description = description
        self._begun = self._moved = time.monotonic()
        self._remaining = remaining or self._by_mean_speed
        self._ended = threading.Event()
        self._lines: threading.Thread | None = None
        self._rich: Progress | None = None
        console = error_console()
        if not quiet and console.is_terminal:
            self._rich = _rich_progress(console, self.remaining)
            self._task = self._rich.add_task(description, total=total)

    def __enter__(self) -> "ProgressBar":
        """Start drawing."""
        if self._rich:
            self._rich.start()
        elif not self._quiet:
            self._lines = threading.Thread(target=self._print_lines, daemon=True)
            self._lines.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop drawing and leave the terminal clean."""
        self._ended.set()
        if self._lines:
            self._lines.join()
        if self._rich:
            self._rich.stop()

    def describe(self, description: str) -> None:
        """Change what is said to be done now."""
        self._description = description
        if self._rich:
            self._rich.update(self._task, description=description)

    def resize(self, total: float) -> None:
        """Change the amount of work."""
        self._total = total
        if self._rich:
            self._rich.update(self._task, total=total)

    def move(self, done: float) -> None:
        """Set how much work is finished in all."""
        self._done, self._moved = done, time.monotonic()
        if self._rich:
            self._rich.update(self._task, completed=done)

    def advance(self, amount: float = 1.0) -> None:
        """Count finished work."""
        self.move(self._done + amount)

    def say(self, text: str) -> None:
        """Print a line above the bar."""
        if self._rich:
            self._rich.console.print(text, markup=False, style="dim", soft_wrap=True)
        else:
            say(self._quiet, text)

    def remaining(self) -> str:
        """The time that remains, in words."""
        seconds = self._remaining()
        if seconds != seconds:
            return "time remaining unknown"
        return f"about {clock(seconds)} remaining" if seconds >= 0.5 else "almost done"

    def _by_mean_speed(self) -> float:
        """Remaining work at the mean speed so far, less the time since the last finished work."""
        if not self._done:
            return float("nan")
        left = (self._moved - self._begun) * (self._total - self._done) / self._done
        left -= time.monotonic() - self._moved
        return left if left > 0 else float("nan")  # it takes longer than expected

    def _print_lines(self) -> None:
        while not self._ended.wait(SECONDS_PER_LINE):
            share = 100 * self._done / self._total if self._total else 100
            spent = clock(time.monotonic() - self._begun)
            say(False, f"{self._description}: {share:.0f} %, {spent} passed, {self.remaining()}")


@contextmanager
def steps(quiet: bool, named: Sequence[tuple[str, float]]) -> Iterator[Iterator[str]]:
    """A bar over named steps with weights: ``next`` of what is yielded begins the following step.

    Parameters
    ----------
    quiet
        Show nothing.
    named
        Description and rough relative duration of each step.
    """
    with ProgressBar(sum(weight for _, weight in named), named[0][0], quiet) as bar:

        def walk() -> Iterator[str]:
            for position, (description, _) in enumerate(named):
                if position:
                    bar.advance(named[position - 1][1])
                bar.describe(description)
                yield description

        yield walk()


class SweepProgress:
    """Callbacks of `evaluation.run` that show a `ProgressBar` over the tasks of a sweep."""

    def __init__(self) -> None:
        self._bar: ProgressBar | None = None
        self._forecast: Forecast | None = None
        self._total = 0

    def begin(self, waiting: Mapping[str, int], stored: int, workers: int, dashboard: str) -> None:
        """Say how much there is to do, and start the bar."""
        from datasets_gen.clouds.point_cloud import counted
        from evaluation.running.progress import Forecast

        self._forecast, self._total = Forecast(dict(waiting), workers), sum(waiting.values())
        if self._bar is None:
            self._bar = ProgressBar(self._total, "starting", False, self._seconds_left).__enter__()
        self._bar.resize(self._total)
        self._bar.move(0)
        where = f", dashboard {dashboard}" if dashboard else ""
        work, done = counted(self._total, "task"), counted(stored, "result")
        self._bar.say(f"{work} to run, {done} stored, {counted(workers, 'worker')}{where}")

    def advance(self, outcome: "Outcome") -> None:
        """Count a task; name a failure at once."""
        assert self._forecast is not None
        assert self._bar is not None
        self._forecast.advance(outcome)
        if not outcome.ok and outcome.kind != "blocked":
            self._bar.say(f"failed: {outcome.task.label}: {outcome.reason}")
        left = sum(self._forecast.waiting.values())
        stages = ", ".join(f"{stage} {count}" for stage, count in self._forecast.waiting.items() if count)
        done = f"{self._total - left} of {self._total} tasks, {self._forecast.throughput:.1f} per second"
        self._bar.describe(f"{done}; waiting: {stages}" if stages else done)
        self._bar.advance()

    def end(self) -> None:
        """Remove the bar."""
        if self._bar is not None:
            self._bar.__exit__()
            self._bar = None

    def _seconds_left(self) -> float:
        return self._forecast.seconds_left if self._forecast else float("nan")


def sweep_progress(quiet: bool) -> "ProgressCallbacks":
    """What shows the progress of a sweep."""
    from evaluation.running.progress import Silent

    return Silent() if quiet else SweepProgress()


def clock(seconds: float) -> str:
    """Minutes and seconds, ``"2:05"``; hours where needed."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"


def _rich_progress(console: "Console", remaining: Callable[[], str]) -> "Progress":
    from rich.progress import (
        BarColumn,
        Progress,
        ProgressColumn,
        Task,
        TaskProgressColumn,
        TextColumn,
        TimeElapsedColumn,
    )
    from rich.text import Text

    class Remaining(ProgressColumn):
        """Asked again at every refresh, so that it falls between two finished pieces of work."""

        max_refresh = 0.5

        def render(self, task: Task) -> Text:
            return Text(remaining(), style="progress.remaining")

    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=None),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        Remaining(),
        console=console,
        transient=True,
    )

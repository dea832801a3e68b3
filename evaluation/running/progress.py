"""What a sweep tells while it runs."""

import time
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from evaluation.running.tasks import STAGES, Report

TYPICAL = {"shape": 8.0, "render": 8.0, "scan": 0.6, "operator": 2.0, "map": 3.0, "score": 1.0}
"""Seconds per task of each stage, until some were measured."""


class Progress(Protocol):
    """Callbacks of `evaluation.run`."""

    def begin(self, waiting: Mapping[str, int], stored: int, workers: int, dashboard: str) -> None:
        """Tasks are about to run: how many by stage, how many results were there already. May come twice."""

    def advance(self, report: Report) -> None:
        """A task has ended."""

    def end(self) -> None:
        """No more tasks."""


class Silent:
    """Says nothing."""

    def begin(self, waiting: Mapping[str, int], stored: int, workers: int, dashboard: str) -> None:
        """Nothing."""

    def advance(self, report: Report) -> None:
        """Nothing."""

    def end(self) -> None:
        """Nothing."""


@dataclass
class Forecast:
    """Throughput and time left, from what tasks of each stage have taken so far."""

    waiting: dict[str, int]
    workers: int
    spent: dict[str, float] = field(default_factory=lambda: defaultdict(float))
    done: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    started: float = field(default_factory=time.perf_counter)

    def advance(self, report: Report) -> None:
        """Count a task that has ended."""
        stage = report.task.stage
        self.waiting[stage] = max(self.waiting.get(stage, 0) - 1, 0)
        self.done[stage] += 1
        self.spent[stage] += report.seconds

    @property
    def throughput(self) -> float:
        """Tasks per second since the start."""
        return sum(self.done.values()) / max(time.perf_counter() - self.started, 1e-9)

    @property
    def seconds_left(self) -> float:
        """Work left over the number of workers."""
        total = 0.0
        for stage, count in self.waiting.items():
            mean = self.spent[stage] / self.done[stage] if self.done.get(stage) else TYPICAL.get(stage, 1.0)
            total += count * mean
        return total / max(self.workers, 1)


class Bars:
    """One progress bar on the terminal: counts by stage, tasks per second, time left."""

    def __init__(self, console: Any = None) -> None:
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
        from rich.progress import Progress as Rich

        self._rich = Rich(
            TextColumn("[bold]{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[rate]}"),
            console=console,
            refresh_per_second=2,
        )
        self._bar: Any = None
        self._forecast = Forecast({}, 1)

    def begin(self, waiting: Mapping[str, int], stored: int, workers: int, dashboard: str) -> None:
        """Show the bar."""
        self._forecast = Forecast(dict(waiting), workers)
        if self._bar is None:
            self._rich.start()
            if dashboard:
                self._rich.console.print(f"dashboard: {dashboard}", highlight=False)
        else:
            self._rich.remove_task(self._bar)
        total = sum(waiting.values())
        self._bar = self._rich.add_task("starting", total=total, rate=f"{stored} stored" if stored else "")

    def advance(self, report: Report) -> None:
        """Move the bar."""
        self._forecast.advance(report)
        left = " ".join(f"{stage} {n}" for stage in STAGES if (n := self._forecast.waiting.get(stage)))
        rate = f"{self._forecast.throughput:.1f} tasks/s, {clock(self._forecast.seconds_left)} left"
        if not report.ok and report.kind != "blocked":
            self._rich.console.print(
                f"[red]failed[/red] {report.task.label}: {report.reason}", highlight=False
            )
        self._rich.update(self._bar, advance=1, description=left or "done", rate=rate)

    def end(self) -> None:
        """Leave the finished bar on the screen."""
        if self._bar is not None:
            self._rich.stop()
            self._bar = None


def clock(seconds: float) -> str:
    """Minutes and seconds, or hours and minutes."""
    whole = round(seconds)
    if whole >= 3600:
        return f"{whole // 3600} h {whole % 3600 // 60:02d} min"
    return f"{whole // 60}:{whole % 60:02d}"

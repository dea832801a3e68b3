"""What a run tells while it goes on: the callbacks, and a forecast of the time that remains."""

import time
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from evaluation.results.outcome import Outcome

TYPICAL = {"shape": 15.0, "render": 1.0, "scan": 0.2, "operator": 1.1, "map": 10.0, "score": 0.5} | {
    "reference": 15.0,
    "shard": 25.0,
}
"""Seconds per task of each stage, until some were measured: means of the presets ``quick`` on two cores."""


class ProgressCallbacks(Protocol):
    """Callbacks of `evaluation.run`."""

    def begin(self, waiting: Mapping[str, int], stored: int, workers: int, dashboard: str) -> None:
        """Tasks are about to run: how many by stage, how many results were there already."""

    def advance(self, outcome: Outcome) -> None:
        """A task has ended."""

    def end(self) -> None:
        """No more tasks."""


class Silent:
    """Says nothing."""

    def begin(self, waiting: Mapping[str, int], stored: int, workers: int, dashboard: str) -> None:
        """Nothing."""

    def advance(self, outcome: Outcome) -> None:
        """Nothing."""

    def end(self) -> None:
        """Nothing."""


def seconds_of(waiting: Mapping[str, int], per_task: Mapping[str, float]) -> float:
    """Seconds that tasks would take one after the other.

    Parameters
    ----------
    waiting
        Number of tasks by stage.
    per_task
        Seconds per task by stage; 1 where a stage is not listed.
    """
    return sum(count * per_task.get(stage, 1.0) for stage, count in waiting.items())


@dataclass
class Forecast:
    """Throughput and time that remains, from what tasks of each stage have taken so far.

    Attributes
    ----------
    waiting : dict of str to int
        Tasks that have not ended, by stage.
    workers : int
    spent : dict of str to float
        Seconds of the tasks that ended, by stage.
    done : dict of str to int
        Number of tasks that ended, by stage.
    """

    waiting: dict[str, int]
    workers: int
    spent: dict[str, float] = field(default_factory=lambda: defaultdict(float))
    done: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    started: float = field(default_factory=time.perf_counter)
    last: float = field(default_factory=time.perf_counter)

    def advance(self, outcome: Outcome) -> None:
        """Count a task that has ended; one that was never run (blocked) says nothing of its stage."""
        stage = outcome.task.stage
        self.waiting[stage] = max(self.waiting.get(stage, 0) - 1, 0)
        self.last = time.perf_counter()
        if outcome.kind != "blocked":
            self.done[stage] += 1
            self.spent[stage] += outcome.seconds

    @property
    def throughput(self) -> float:
        """Tasks per second since the start."""
        return sum(self.done.values()) / max(time.perf_counter() - self.started, 1e-9)

    @property
    def seconds_left(self) -> float:
        """Seconds that remain: the measured mean of each stage times its waiting tasks, over the workers.

        Stages of which no task has ended count with `TYPICAL`. The time since the last task ended is
        subtracted, so that the value falls while tasks run.
        """
        measured = {stage: self.spent[stage] / count for stage, count in self.done.items() if count}
        left = seconds_of(self.waiting, {**TYPICAL, **measured}) / max(self.workers, 1)
        return max(left - (time.perf_counter() - self.last), 0.0)

"""The plan of an experiment: its tasks, and the rows of the table that they fill."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from evaluation.experiment.tasks import Task


@dataclass(frozen=True, slots=True)
class PlannedRow:
    """A row of the results table before its score is known.

    Attributes
    ----------
    columns : Mapping
        What the row is about: data set, method, poses, thresholds, seed, keys of the results behind it.
    score : str
        Key of the score task that fills the other columns.
    """

    columns: Mapping[str, Any]
    score: str


@dataclass
class Plan:
    """Tasks and rows of an experiment.

    Attributes
    ----------
    tasks : dict of str to Task
        By key; inputs come before the tasks that need them.
    rows : list of PlannedRow
    unavailable : dict of str to str
        Labels of methods that cannot run here, and why.
    """

    tasks: dict[str, Task] = field(default_factory=dict)
    rows: list[PlannedRow] = field(default_factory=list)
    unavailable: dict[str, str] = field(default_factory=dict)

    def add(self, task: Task) -> str:
        """Enter a task, unless it is there already; returns its key."""
        self.tasks.setdefault(task.key, task)
        return task.key

"""Which tasks can run: those whose inputs are there, the earliest planned first."""

import heapq
from collections import Counter, defaultdict
from collections.abc import Collection, Iterator, Mapping

from evaluation.experiment.tasks import STAGES, Task


class TaskQueue:
    """Tasks whose inputs are there, the earliest planned first; and what follows when one ends.

    Parameters
    ----------
    tasks
        To be run, inputs before the tasks that need them.
    stored
        Keys of results that are there already.

    Raises
    ------
    ValueError
        If a task needs a result that is neither stored nor planned.
    """

    def __init__(self, tasks: Collection[Task], stored: Collection[str]) -> None:
        self._tasks = list(tasks)
        number = {task.key: i for i, task in enumerate(self._tasks)}
        self._missing = [0] * len(self._tasks)
        self._followers: dict[str, list[int]] = defaultdict(list)
        self._ready: list[int] = []
        self._ended: set[str] = set()
        for i, task in enumerate(self._tasks):
            for key in dict.fromkeys(task.inputs.values()):
                if key in number:
                    self._missing[i] += 1
                    self._followers[key].append(i)
                elif key not in stored:
                    raise ValueError(f"task {task.key!r} needs {key!r}, which is neither stored nor planned")
            if not self._missing[i]:
                self._ready.append(i)
        heapq.heapify(self._ready)

    def pop(self) -> Task | None:
        """The next task that can run; None if all wait for others."""
        return self._tasks[heapq.heappop(self._ready)] if self._ready else None

    def succeeded(self, task: Task) -> None:
        """Free the tasks that waited for this one alone."""
        self._ended.add(task.key)
        for i in self._followers.pop(task.key, ()):
            self._missing[i] -= 1
            if not self._missing[i] and self._tasks[i].key not in self._ended:
                heapq.heappush(self._ready, i)

    def failed(self, task: Task) -> Iterator[Task]:
        """Give up on what needs this task; yields those tasks, each once."""
        self._ended.add(task.key)
        waiting = list(self._followers.pop(task.key, ()))
        while waiting:
            follower = self._tasks[waiting.pop(0)]
            if follower.key not in self._ended:
                self._ended.add(follower.key)
                waiting.extend(self._followers.pop(follower.key, ()))
                yield follower


def by_stage(tasks: Collection[Task]) -> Mapping[str, int]:
    """Number of tasks of each stage that has any, in the order of the stages."""
    counts = Counter(task.stage for task in tasks)
    return {stage: counts[stage] for stage in STAGES if counts[stage]}

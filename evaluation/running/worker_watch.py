"""Looks after the workers of a run: replaces the lost, ends the frozen, gives up if there are none.

Dask starts a worker again that ends, but not one that ends, or hangs, while it starts. A task's own watchdog
(`attempts`) ends its process at the time limit, unless the whole process is stopped; then nothing is heard of
it any more.
"""

import logging
import time
from typing import Any

from datasets_gen.records import InputError
from evaluation.running.cluster import Cluster
from evaluation.running.local_workers import SLOWER, kill_process

log = logging.getLogger(__name__)

LOOK_EVERY = 5.0
"""Seconds between looks."""

REPLACE_AFTER = 15.0
"""Seconds with fewer workers than were started after which those of this machine are replaced."""

GRACE = 30.0
"""Seconds past the time limit of tasks after which a worker that says nothing is ended."""


class WorkerWatch:
    """Looks at the workers of a run every few seconds, whenever `look` is called.

    Parameters
    ----------
    cluster
    limit
        Seconds per task.
    """

    def __init__(self, cluster: Cluster, limit: float) -> None:
        self._cluster, self._limit = cluster, limit
        self._local: Any = getattr(
            cluster.client, "cluster", None
        )  # a running cluster looks after its workers
        self._looked = time.monotonic()
        self._deserted = self._short = 0.0  # seconds without any worker, and with too few
        self._replace_after = REPLACE_AFTER
        self._silent: dict[Any, tuple[Any, float]] = {}  # when each was heard, and seconds since then

    def look(self) -> None:
        """Look, if it is time to.

        Raises
        ------
        InputError
            If there has been no worker for longer than the cluster's patience.
        """
        now = time.monotonic()
        passed = min(now - self._looked, 2 * LOOK_EVERY)  # more if this process was stopped meanwhile
        if passed < LOOK_EVERY:
            return
        self._looked = now
        there = self._workers()
        self._deserted = 0.0 if there else self._deserted + passed
        self._short = 0.0 if there >= self._cluster.workers else self._short + passed
        if self._deserted >= self._cluster.patience:
            raise InputError(
                f"no worker for {self._deserted:.0f} s: all are gone; results are stored, the same command "
                "goes on"
            )
        if self._local is not None:
            if self._short >= self._replace_after:
                self._short, self._replace_after = (
                    0.0,
                    SLOWER * self._replace_after,
                )  # as they may be slow to start
                self._replace_missing()
            self._end_silent(passed)

    def _workers(self) -> int:
        try:
            return sum(self._cluster.client.nthreads().values())
        except (OSError, TimeoutError):  # no scheduler answers
            return 0

    def _replace_missing(self) -> None:
        """Start those workers of this machine afresh that the scheduler does not know."""
        local = self._local
        known = {worker.name for worker in list(local.scheduler.workers.values())}
        missing = [name for name in local.worker_spec if name not in known]
        log.warning("%d of %d workers ended; they are replaced", len(missing), self._cluster.workers)
        start = 1 + max((name for name in local.worker_spec if isinstance(name, int)), default=-1)
        for i, name in enumerate(missing):
            kill_process(
                getattr(local.workers.get(name), "pid", None)
            )  # Dask waits for one that hangs as it starts
            del local.worker_spec[name]
            local.worker_spec[start + i] = local.new_spec  # other names: Dask has not done with the old ones
        local.scale(self._cluster.workers)

    def _end_silent(self, passed: float) -> None:
        """End workers of which nothing has been heard for longer than any task may hold the interpreter."""
        heard = {worker.name: worker.last_seen for worker in list(self._local.scheduler.workers.values())}
        for name, last in heard.items():  # a time of the system's clock, which may jump: compared with itself
            before, silent = self._silent.get(name, (None, 0.0))
            self._silent[name] = last, silent + passed if last == before else 0.0
            if self._silent[name][1] > self._limit + GRACE:
                log.warning("a worker is silent; it is replaced")
                kill_process(getattr(self._local.workers.get(name), "pid", None))
                self._silent[name] = last, 0.0

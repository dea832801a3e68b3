"""Dask: a cluster on this machine, or one that runs already."""

import contextlib
import logging
import os
import uuid
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from datasets_gen.records import InputError
from evaluation.running.environment import usable_processors, versions
from evaluation.running.process import hold_interrupts

if TYPE_CHECKING:
    from distributed import Client

SETTINGS = {
    "distributed.scheduler.worker-ttl": None,  # compiled code may hold the interpreter for minutes
    "distributed.scheduler.allowed-failures": 3,
    "distributed.admin.tick.limit": "1h",
    "distributed.worker.memory.target": False,  # results go to the folder: nothing to spill
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.nanny.pre-spawn-environ.NUMBA_NUM_THREADS": 1,
    "distributed.nanny.pre-spawn-environ.OMP_NUM_THREADS": 1,
    "distributed.nanny.pre-spawn-environ.OPENBLAS_NUM_THREADS": 1,
    "distributed.nanny.pre-spawn-environ.MKL_NUM_THREADS": 1,
}


@dataclass(frozen=True)
class Cluster:
    """A connected cluster.

    Attributes
    ----------
    client
    workers : int
        Threads that run tasks.
    dashboard : str
        Address of Dask's dashboard, or how to get one; empty if there is none.
    patience : float
        Seconds without any worker after which a run gives up: a queue may bring new ones to a running
        cluster, nothing does to a local one whose workers cannot be restarted.
    """

    client: "Client"
    workers: int
    dashboard: str
    patience: float


@contextlib.contextmanager
def connect(folder: Path, jobs: int | None, scheduler: str | None) -> Iterator[Cluster]:
    """A cluster whose workers see the results folder.

    Parameters
    ----------
    folder
        The results folder.
    jobs
        Worker processes on this machine, one thread each; the number of usable processors if None.
        Ignored with a scheduler.
    scheduler
        Address of a running scheduler, ``"tcp://host:port"``; None starts a local cluster.

    Raises
    ------
    InputError
        If the scheduler cannot be reached or has no workers, or if they do not see the folder or have other
        versions of the libraries.
    """
    import dask
    from distributed import Client, LocalCluster

    with dask.config.set(SETTINGS), contextlib.ExitStack() as stack:
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        if scheduler is None:
            with hold_interrupts():
                local = LocalCluster(
                    n_workers=jobs or usable_processors(),
                    threads_per_worker=1,
                    processes=True,
                    dashboard_address=":0",
                    silence_logs=logging.CRITICAL,
                )
                client = Client(stack.enter_context(local))
        else:
            client = _join(Client, scheduler)
        stack.enter_context(client)
        _check(client, folder)
        threads = sum(client.nthreads().values())
        yield Cluster(client, threads, _dashboard(client), 60.0 if scheduler is None else 3600.0)


def _join(kind: type["Client"], scheduler: str) -> "Client":
    try:
        client = kind(scheduler, timeout=10)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            f"no Dask scheduler answers at {scheduler!r}: start `dask scheduler` there"
        ) from error
    if not client.nthreads():
        client.close()
        raise InputError(f"the scheduler at {scheduler!r} has no workers: start `dask worker {scheduler}`")
    return client


def _check(client: "Client", folder: Path) -> None:
    """Check that workers see the results folder, through which all results go, and have the same versions.

    Keys of results hold the versions here: with others on a worker they would name the wrong results.
    """
    token = folder / f".probe-{uuid.uuid4().hex}"
    token.touch()
    try:
        seen: dict[str, Any] = client.run(os.path.exists, str(token))
    finally:
        token.unlink(missing_ok=True)
    blind = sorted(address for address, found in seen.items() if found is not True)
    if blind:
        raise InputError(
            f"worker {blind[0]} does not see {str(folder)!r}; use a folder on a shared file system"
        )
    _compare_versions(versions(), client.run(versions, on_error="return"))


def _compare_versions(here: Mapping[str, str], found: Mapping[str, Any]) -> None:
    """Raise `InputError` for the first worker whose versions differ from those of this process."""
    for address, there in sorted(found.items()):
        if isinstance(there, BaseException):
            raise InputError(f"worker {address} cannot use medialbench ({there}); install it there")
        for name, wanted in here.items():
            if there.get(name) != wanted:
                raise InputError(
                    f"worker {address} has {name} {there.get(name, 'missing')}, this process has {wanted}; "
                    "install the same versions everywhere"
                )


def _dashboard(client: "Client") -> str:
    if not find_spec("bokeh"):
        return "off (pip install bokeh to have it)"
    return str(client.dashboard_link or "")

"""Dask: a cluster on this machine, or one that runs already.

A local one listens on the loopback interface alone and talks TLS with a certificate that is made for the run:
another user of the machine can neither hand it tasks, which is to run code, nor read what it sends.
"""

import contextlib
import logging
import os
import uuid
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from datasets_gen.records import InputError, cannot_write
from evaluation.running.environment import usable_processors, versions
from evaluation.running.local_workers import allow_open_files, local_cluster
from evaluation.running.process import SAFE_PATH, hold_interrupts
from evaluation.running.scheduler_check import check_scheduler
from evaluation.running.tls import TlsFiles, certificate_of_this_run, security_of

if TYPE_CHECKING:
    from distributed import Client
    from distributed.security import Security

SETTINGS = {
    "distributed.scheduler.worker-ttl": None,  # compiled code may hold the interpreter for minutes
    "distributed.scheduler.allowed-failures": 3,
    "distributed.deploy.lost-worker-timeout": "1h",  # `worker_watch` replaces what is lost
    "distributed.admin.tick.limit": "1h",
    "distributed.worker.memory.target": False,  # results go to the folder: nothing to spill
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.nanny.pre-spawn-environ.NUMBA_NUM_THREADS": 1,
    "distributed.nanny.pre-spawn-environ.OMP_NUM_THREADS": 1,
    "distributed.nanny.pre-spawn-environ.OPENBLAS_NUM_THREADS": 1,
    "distributed.nanny.pre-spawn-environ.MKL_NUM_THREADS": 1,
    "distributed.nanny.pre-spawn-environ.PYTHONSAFEPATH": SAFE_PATH,  # or a user's struct.py hides Python's
}

SPAWNED = [name.rpartition(".")[2] for name in SETTINGS if "pre-spawn-environ" in name] + ["PYTHONHASHSEED"]
"""Variables of the environment that Dask sets before it starts a worker."""

LOOPBACK = "127.0.0.1"

PAGES = ("distributed.http.scheduler.info", "distributed.http.statics")
"""What the scheduler's web server has beside the dashboard, and nothing without one."""


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
def connect(
    folder: Path,
    jobs: int | None,
    scheduler: str | None,
    tls: TlsFiles | None = None,
    dashboard: bool = False,
) -> Iterator[Cluster]:
    """A cluster whose workers see the results folder.

    Parameters
    ----------
    folder
        The results folder.
    jobs
        Worker processes on this machine, one thread each; the number of usable processors if None.
        Ignored with a scheduler.
    scheduler
        Address of a running scheduler, ``"tls://host:port"`` or ``"tcp://host:port"``; None starts a local
        cluster.
    tls
        Certificates for a running scheduler; Dask's configuration has them if None.
    dashboard
        Whether a local cluster has a dashboard, which every user of this machine can see.

    Raises
    ------
    InputError
        If the scheduler cannot be reached or has no workers, or if they do not see the folder or have other
        versions of the libraries.
    """
    import dask

    import_module("distributed")  # adds its own settings, before some are replaced for a while
    with dask.config.set({**SETTINGS, **_web_pages(dashboard)}), contextlib.ExitStack() as stack:
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        stack.callback(_put_back, {name: os.environ.get(name) for name in SPAWNED})
        if scheduler is None:
            client = _start(stack, jobs or usable_processors(), dashboard)
        else:
            client = _join(scheduler, security_of(scheduler, tls))
        stack.enter_context(client)
        _check(client, folder)
        threads = sum(client.nthreads().values())
        shown = _dashboard(client) if dashboard or (scheduler and find_spec("bokeh")) else ""
        yield Cluster(client, threads, shown, 60.0 if scheduler is None else 3600.0)


def _put_back(environment: Mapping[str, str | None]) -> None:
    """Set variables of the environment again: Dask leaves them here as its workers get them."""
    for name, value in environment.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value


def _web_pages(dashboard: bool) -> dict[str, list[str]]:
    """Dask starts web servers whatever is asked for; they answer nothing but the dashboard's pages."""
    return {
        "distributed.scheduler.http.routes": list(PAGES) if dashboard else [],
        "distributed.worker.http.routes": [],
    }


def _start(stack: contextlib.ExitStack, workers: int, dashboard: bool) -> "Client":
    """A cluster on this machine that ends with the stack, and its client."""
    from distributed import Client, LocalCluster

    allow_open_files(workers)
    security = certificate_of_this_run()
    cluster = partial(
        LocalCluster,
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        host=LOOPBACK,
        protocol="tls://",
        security=security,
        dashboard_address=f"{LOOPBACK}:0",
        worker_dashboard_address=None,
        scheduler_kwargs={"dashboard": dashboard},
        silence_logs=logging.CRITICAL,
    )
    with hold_interrupts():
        return Client(stack.enter_context(local_cluster(cluster)), security=security)


def _join(scheduler: str, security: "Security") -> "Client":
    from distributed import Client

    check_scheduler(scheduler, security, versions())
    try:
        client = Client(scheduler, timeout=10, security=security)
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
    try:
        token.touch()
    except OSError as error:
        raise cannot_write(folder, error) from error
    try:
        seen: dict[str, Any] = client.run(os.path.exists, str(token))
    finally:
        with contextlib.suppress(OSError):
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

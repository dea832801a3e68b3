"""Workers that do not start are started again, and a run gives up with one line."""

import multiprocessing
import os
import signal
import time

import pytest

from datasets_gen import InputError
from evaluation.running import local_workers
from evaluation.running.local_workers import allow_open_files, local_cluster

FORK = multiprocessing.get_context("fork")


class Closed:
    """A cluster that can be closed when its process has ended, if it has one."""

    def __init__(self, process=None):
        self.process, self.closed = process, 0

    def close(self, timeout):
        self.closed += 1
        if self.process is not None:
            self.process.join(timeout)
            if self.process.exitcode is None:
                raise TimeoutError


def failing(times, error):
    """Fails so many times."""
    calls = []

    def make():
        calls.append(1)
        if len(calls) <= times:
            raise error
        return Closed()

    return make


@pytest.mark.parametrize(
    "error", [RuntimeError("Nanny failed to start."), TimeoutError(), OSError(24, "many")]
)
def test_workers_are_started_again(error):
    with local_cluster(failing(2, error)) as cluster:
        assert not cluster.closed
    assert cluster.closed == 1


def test_a_run_gives_up_with_the_cause():
    error = RuntimeError("Nanny failed to start.")
    error.__cause__ = OSError("no\nspace")
    with (
        pytest.raises(InputError, match=r"do not start \(OSError: no space\); try fewer"),
        local_cluster(failing(3, error)),
    ):
        pass


def stop():
    os.kill(os.getpid(), signal.SIGSTOP)


@pytest.fixture
def older():
    """A process of somebody else."""
    process = FORK.Process(target=time.sleep, args=(60,))
    process.start()
    yield process
    assert process.is_alive()
    process.kill()
    process.join()


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="processes cannot be stopped here")
def test_processes_that_hang_as_they_start_are_ended(monkeypatch, older):
    monkeypatch.setattr(local_workers, "START_WITHIN", 0.2)

    def make():
        hangs = FORK.Process(target=stop)
        hangs.start()
        hangs.join()  # for ever
        return Closed(hangs)

    with local_cluster(make) as cluster:
        assert cluster.process.exitcode == -signal.SIGKILL


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="processes cannot be stopped here")
def test_a_cluster_that_does_not_close_is_closed_by_force(monkeypatch, older):
    monkeypatch.setattr(local_workers, "CLOSE_WITHIN", 0.5)

    def make():
        hangs = FORK.Process(target=stop)
        hangs.start()
        return Closed(hangs)

    with local_cluster(make) as cluster:
        pass
    assert cluster.closed == 2
    assert cluster.process.exitcode == -signal.SIGKILL


@pytest.mark.parametrize("error", [OSError, ValueError])
def test_a_limit_of_open_files_is_raised_or_named(error, monkeypatch):
    resource = pytest.importorskip("resource")
    limits = [100, 1000]
    monkeypatch.setattr(resource, "getrlimit", lambda _: tuple(limits))

    def setrlimit(_, wanted):
        if wanted[0] > limits[1]:
            raise error
        limits[:] = wanted

    monkeypatch.setattr(resource, "setrlimit", setrlimit)
    allow_open_files(2)
    assert limits == [100, 1000]
    allow_open_files(10)
    assert limits == [224, 1000]
    with pytest.raises(InputError, match=r"only 1000 files .* 100 workers need 1664; raise the limit"):
        allow_open_files(100)

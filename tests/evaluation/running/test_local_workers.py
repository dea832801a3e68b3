"""Workers that do not start are started again, and a run gives up with one line."""

import multiprocessing
import os
import signal
import time

import pytest

from datasets_gen import InputError
from evaluation.running import local_workers
from evaluation.running.local_workers import allow_open_files, start_workers


def failing(times, error):
    """Fails so many times."""
    calls = []

    def make():
        calls.append(1)
        if len(calls) <= times:
            raise error
        return "cluster"

    return make


@pytest.mark.parametrize(
    "error", [RuntimeError("Nanny failed to start."), TimeoutError(), OSError(24, "many")]
)
def test_workers_are_started_again(error):
    assert start_workers(failing(2, error)) == "cluster"


def test_a_run_gives_up_with_the_cause():
    error = RuntimeError("Nanny failed to start.")
    error.__cause__ = OSError("no\nspace")
    with pytest.raises(InputError, match=r"do not start \(OSError: no space\); try fewer"):
        start_workers(failing(3, error))


def stop():
    os.kill(os.getpid(), signal.SIGSTOP)


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="processes cannot be stopped here")
def test_processes_that_hang_as_they_start_are_ended(monkeypatch):
    monkeypatch.setattr(local_workers, "START_WITHIN", 0.2)
    fork = multiprocessing.get_context("fork")
    older = fork.Process(target=time.sleep, args=(60,))
    older.start()

    def make():
        hangs = fork.Process(target=stop)
        hangs.start()
        hangs.join()  # for ever
        return hangs.exitcode

    assert start_workers(make) == -signal.SIGKILL
    assert older.is_alive()
    older.kill()
    older.join()


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

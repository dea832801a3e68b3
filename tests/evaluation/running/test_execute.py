import os
import signal
import threading
import time
from queue import SimpleQueue

import pytest

from datasets_gen import InputError
from evaluation.running import execute
from evaluation.running.cluster import Cluster, connect


class Deserted:
    """A client whose workers are gone; they come back after some looks, or never."""

    def __init__(self, looks):
        self.looks = looks

    def nthreads(self):
        self.looks -= 1
        return {"tcp://one": 1} if self.looks < 0 else {}


def test_a_sweep_does_not_wait_for_ever_for_workers(monkeypatch):
    monkeypatch.setattr(execute, "LOOK_EVERY", 0.01)
    with pytest.raises(InputError, match="no worker for"):
        execute._next(SimpleQueue(), Cluster(Deserted(10**9), 1, "", patience=0.05))


def test_workers_may_come_back(monkeypatch):
    monkeypatch.setattr(execute, "LOOK_EVERY", 0.01)
    done = SimpleQueue()
    client = Deserted(3)
    threading.Timer(0.3, done.put, ["future"]).start()
    assert execute._next(done, Cluster(client, 1, "", patience=0.1)) == "future"
    assert client.looks < 0


class Local:
    """A cluster on this machine whose workers come back when it is told to have some."""

    def __init__(self):
        self.workers, self.worker_spec, self.new_spec = {0: "gone"}, {0: "gone"}, "new"
        self.wanted = 0

    def scale(self, count):
        self.wanted = count


def test_workers_of_this_machine_that_ended_while_they_started_are_replaced(monkeypatch):
    monkeypatch.setattr(execute, "LOOK_EVERY", 0.01)
    monkeypatch.setattr(execute, "REPLACE_AFTER", 0.03)
    client = Deserted(10**9)
    client.cluster = Local()
    with pytest.raises(InputError, match="no worker for"):
        execute._next(SimpleQueue(), Cluster(client, 2, "", patience=0.1))
    assert (client.cluster.wanted, client.cluster.worker_spec) == (2, {1: "new", 2: "new"})


@pytest.mark.slow
def test_dask_has_new_workers_after_that(tmp_path):
    from distributed.core import Status

    with connect(tmp_path, 1, None) as cluster:
        first = cluster.client.submit(os.getpid, pure=False).result(timeout=30)
        cluster.client.cluster.workers[0].status = Status.starting  # as while it starts a process
        os.kill(first, signal.SIGKILL)
        deadline = time.monotonic() + 30
        while cluster.client.nthreads():
            assert time.monotonic() < deadline
            time.sleep(0.1)
        execute._replace_workers(cluster)
        assert cluster.client.submit(os.getpid, pure=False).result(timeout=60) != first

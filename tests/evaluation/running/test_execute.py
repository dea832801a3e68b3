import threading
from queue import SimpleQueue

import pytest

from datasets_gen import InputError
from evaluation.running import execute
from evaluation.running.cluster import Cluster


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

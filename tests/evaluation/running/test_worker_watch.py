"""Workers that are gone for good are replaced, frozen ones ended, and nobody is waited for without end."""

import itertools
import os
import signal
import time
from types import SimpleNamespace

import pytest

from datasets_gen import InputError
from evaluation.running import worker_watch
from evaluation.running.cluster import Cluster, connect
from evaluation.running.worker_watch import WorkerWatch


class Clock:
    """Time that passes when it is told to."""

    def __init__(self, monkeypatch):
        self.now = 1000.0
        monkeypatch.setattr(worker_watch.time, "monotonic", lambda: self.now)


class Workers:
    """A client and its cluster on this machine; workers come when they are told to, by number."""

    def __init__(self, *there, wanted=2, local=True):
        self.there, self.scaled = set(there), []
        self.heard, self.now = {}, itertools.count()
        spec = dict.fromkeys(range(wanted), "old")
        if local:
            self.cluster = SimpleNamespace(
                worker_spec=spec, new_spec="new", scheduler=self, scale=self.scaled.append
            )
            self.cluster.workers = {name: SimpleNamespace(pid=100 + name) for name in spec}

    @property
    def workers(self):
        heard = next(self.now)
        return {
            name: SimpleNamespace(name=name, last_seen=self.heard.get(name, heard)) for name in self.there
        }

    def nthreads(self):
        return dict.fromkeys(self.there, 1)


@pytest.fixture
def clock(monkeypatch):
    return Clock(monkeypatch)


@pytest.fixture
def killed(monkeypatch):
    found = []
    monkeypatch.setattr(worker_watch, "kill_process", found.append)
    return found


def watch_of(client, wanted=2, patience=60.0):
    return WorkerWatch(Cluster(client, wanted, "", patience), 10.0)


def looks(watch, clock, seconds, every=5.0):
    end = clock.now + seconds
    while clock.now < end:
        clock.now += every
        watch.look()


def test_one_of_two_that_is_gone_is_replaced_and_its_process_ended(clock, killed):
    client = Workers(0)
    watch = watch_of(client)
    looks(watch, clock, 10)
    assert client.scaled == []
    looks(watch, clock, 5)
    assert client.cluster.worker_spec == {0: "old", 2: "new"}
    assert (client.scaled, killed) == ([2], [101])


def test_a_replacement_has_longer_to_start_each_time(clock, killed):
    client = Workers(0)
    watch = watch_of(client)
    looks(watch, clock, 15 + 55)
    assert client.cluster.worker_spec == {0: "old", 2: "new"}
    looks(watch, clock, 5)
    assert client.cluster.worker_spec == {0: "old", 3: "new"}
    assert client.scaled == [2, 2]


def test_all_that_are_gone_are_replaced_and_not_waited_for_without_end(clock, killed):
    client = Workers()
    with pytest.raises(InputError, match="no worker for 60 s: all are gone; results are stored"):
        looks(watch_of(client), clock, 1000)
    assert client.cluster.worker_spec == {2: "new", 3: "new"}


def test_workers_may_come_back(clock, killed):
    client = Workers()
    watch = watch_of(client)
    for _ in range(20):
        client.there = set()
        looks(watch, clock, 10)
        client.there = {0, 1}
        looks(watch, clock, 5)
    assert client.scaled == []


def test_time_in_which_this_process_was_stopped_does_not_count(clock, killed):
    client = Workers()
    watch = watch_of(client)
    clock.now += 1e6
    watch.look()
    assert client.scaled == []


def test_a_running_cluster_looks_after_its_workers(clock, killed):
    client = Workers(0, local=False)
    looks(watch_of(client), clock, 1000)
    client.there = set()
    with pytest.raises(InputError, match="no worker"):
        looks(watch_of(client), clock, 1000)
    assert killed == []


def test_a_scheduler_that_does_not_answer_has_no_workers(clock):
    def lost():
        raise OSError("lost connection")

    client = Workers(0, local=False)
    client.nthreads = lost
    with pytest.raises(InputError, match="no worker"):
        looks(watch_of(client), clock, 1000)


@pytest.mark.parametrize("jump", [0.0, -1e9, 1e9])
def test_a_worker_that_says_nothing_is_ended(jump, clock, killed):
    """After the limit of 10 s and 30 s more, whatever the system's clock says; one that speaks is not."""
    client = Workers(0, 1)
    watch = watch_of(client)
    for step in range(9):
        assert killed == []
        client.heard = {0: 50.0, 1: step + jump * (step > 4)}
        looks(watch, clock, 5)
    looks(watch, clock, 5)
    assert killed == [100]


@pytest.mark.slow
def test_dask_has_new_workers_after_that(tmp_path, monkeypatch):
    from distributed.core import Status

    monkeypatch.setattr(worker_watch, "LOOK_EVERY", 0.1)
    monkeypatch.setattr(worker_watch, "REPLACE_AFTER", 0.3)
    with connect(tmp_path, 2, None) as cluster:
        first = cluster.client.run(os.getpid)
        cluster.client.cluster.workers[0].status = Status.starting  # as while it starts a process
        os.kill(cluster.client.cluster.workers[0].pid, signal.SIGKILL)
        watch = WorkerWatch(cluster, 10.0)
        deadline = time.monotonic() + 120
        while len(now := cluster.client.run(os.getpid, on_error="ignore")) < 2 or now == first:
            assert time.monotonic() < deadline
            watch.look()
            time.sleep(0.1)
        assert len(set(now.values()) & set(first.values())) == 1

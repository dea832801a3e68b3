import threading
from queue import SimpleQueue

import pytest
from hypothesis import given
from hypothesis import strategies as st

from datasets_gen import InputError
from evaluation.running import sweep
from evaluation.running.cluster import Cluster
from evaluation.running.sweep import Queue
from evaluation.running.tasks import Task


def task(key, *inputs):
    return Task(str(key), "scan", {}, {f"i{n}": str(each) for n, each in enumerate(inputs)}, str(key))


@st.composite
def graphs(draw):
    """Random acyclic tasks: each needs some of the earlier ones."""
    n = draw(st.integers(1, 25))
    return [
        task(i, *draw(st.sets(st.integers(0, i - 1), max_size=3) if i else st.just(set()))) for i in range(n)
    ]


@given(graphs(), st.randoms(use_true_random=False))
def test_every_task_runs_once_after_its_inputs(tasks, random):
    queue, flying, done = Queue(tasks, ()), [], []
    while True:
        while (ready := queue.pop()) is not None:
            assert set(ready.inputs.values()) <= set(done)
            flying.append(ready)
        if not flying:
            break
        ended = flying.pop(random.randrange(len(flying)))
        done.append(ended.key)
        queue.succeeded(ended)
    assert sorted(done) == sorted(t.key for t in tasks)


@given(graphs(), st.data())
def test_a_failure_blocks_exactly_what_needs_it(tasks, data):
    bad = {t.key for t in data.draw(st.lists(st.sampled_from(tasks), max_size=3))}
    needs_bad = set(bad)
    for each in tasks:
        if needs_bad & set(each.inputs.values()):
            needs_bad.add(each.key)
    queue, ran, blocked = Queue(tasks, ()), [], []
    while (ready := queue.pop()) is not None:
        ran.append(ready.key)
        if ready.key in bad:
            blocked += [each.key for each in queue.failed(ready)]
        else:
            queue.succeeded(ready)
    assert len(ran + blocked) == len(set(ran + blocked)) == len(tasks)
    assert set(blocked) | (bad & set(ran)) == needs_bad


def test_stored_inputs_need_not_run():
    queue = Queue([task("b", "a")], {"a"})
    assert queue.pop().key == "b"
    with pytest.raises(ValueError, match="neither stored nor planned"):
        Queue([task("b", "a")], ())


def test_the_earliest_planned_goes_first():
    queue = Queue([task("a"), task("b", "a"), task("c")], ())
    first = queue.pop()
    queue.succeeded(first)
    assert queue.pop().key == "b"


class Deserted:
    """A client whose workers are gone; they come back after some looks, or never."""

    def __init__(self, looks):
        self.looks = looks

    def nthreads(self):
        self.looks -= 1
        return {"tcp://one": 1} if self.looks < 0 else {}


def test_a_sweep_does_not_wait_for_ever_for_workers(monkeypatch):
    monkeypatch.setattr(sweep, "LOOK_EVERY", 0.01)
    with pytest.raises(InputError, match="no worker for"):
        sweep._next(SimpleQueue(), Cluster(Deserted(10**9), 1, "", patience=0.05))


def test_workers_may_come_back(monkeypatch):
    monkeypatch.setattr(sweep, "LOOK_EVERY", 0.01)
    done = SimpleQueue()
    client = Deserted(3)
    threading.Timer(0.3, done.put, ["future"]).start()
    assert sweep._next(done, Cluster(client, 1, "", patience=0.1)) == "future"
    assert client.looks < 0

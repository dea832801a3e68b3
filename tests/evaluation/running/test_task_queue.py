import pytest
from hypothesis import given
from hypothesis import strategies as st

from evaluation.experiment.tasks import Task
from evaluation.running.task_queue import TaskQueue


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
    queue, flying, done = TaskQueue(tasks, ()), [], []
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
    queue, ran, blocked = TaskQueue(tasks, ()), [], []
    while (ready := queue.pop()) is not None:
        ran.append(ready.key)
        if ready.key in bad:
            blocked += [each.key for each in queue.failed(ready)]
        else:
            queue.succeeded(ready)
    assert len(ran + blocked) == len(set(ran + blocked)) == len(tasks)
    assert set(blocked) | (bad & set(ran)) == needs_bad


def test_stored_inputs_need_not_run():
    queue = TaskQueue([task("b", "a")], {"a"})
    assert queue.pop().key == "b"
    with pytest.raises(ValueError, match="neither stored nor planned"):
        TaskQueue([task("b", "a")], ())


def test_the_earliest_planned_goes_first():
    queue = TaskQueue([task("a"), task("b", "a"), task("c")], ())
    first = queue.pop()
    queue.succeeded(first)
    assert queue.pop().key == "b"

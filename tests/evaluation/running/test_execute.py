import threading
from queue import SimpleQueue

from evaluation.running import execute


class Looks:
    """A watch that counts its looks."""

    def __init__(self):
        self.count = 0

    def look(self):
        self.count += 1


def test_workers_are_looked_at_while_no_task_ends_and_when_one_does(monkeypatch):
    monkeypatch.setattr(execute, "LOOK_EVERY", 0.01)
    done, watch = SimpleQueue(), Looks()
    threading.Timer(0.2, done.put, ["first"]).start()
    assert execute._next(done, watch.look) == "first"
    assert watch.count > 2
    done.put("second")
    before = watch.count
    assert execute._next(done, watch.look) == "second"
    assert watch.count == before + 1

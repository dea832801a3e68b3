import pytest

from evaluation.experiment.tasks import Task
from evaluation.results.outcome import Outcome
from evaluation.running import progress
from evaluation.running.progress import TYPICAL, Forecast, seconds_of


def ended(stage, seconds, kind=""):
    return Outcome(Task("key", stage, {}, {}, "label"), not kind, kind=kind, seconds=seconds)


@pytest.fixture
def clock(monkeypatch):
    """A clock that stands still until it is moved."""
    now = [100.0]
    monkeypatch.setattr(progress.time, "perf_counter", lambda: now[0])
    return now


def forecast(**waiting):
    return Forecast(waiting, 2, started=100.0, last=100.0)


def test_typical_durations_count_until_some_are_measured(clock):
    assert forecast(map=4, scan=10).seconds_left == (4 * TYPICAL["map"] + 10 * TYPICAL["scan"]) / 2


def test_the_measured_mean_of_a_stage_replaces_them(clock):
    found = forecast(map=4)
    found.advance(ended("map", 30.0))
    found.advance(ended("map", 50.0))
    assert found.seconds_left == 2 * 40 / 2


def test_what_remains_falls_while_tasks_run_and_never_below_zero(clock):
    found = forecast(map=2)
    before = found.seconds_left
    clock[0] += 3
    assert found.seconds_left == before - 3
    clock[0] += 1000
    assert found.seconds_left == 0


def test_blocked_tasks_are_not_waited_for_and_say_nothing_of_their_stage(clock):
    found = forecast(score=2)
    found.advance(ended("score", 0.0, "blocked"))
    assert found.seconds_left == TYPICAL["score"] / 2


def test_seconds_of_tasks():
    assert seconds_of({"map": 2, "strange": 3}, {"map": 5.0}) == 13

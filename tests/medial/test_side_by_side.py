"""Two calls at once: results, errors and messages in order."""

import logging
import threading
from concurrent.futures import Future

import pytest

from medial.side_by_side import side_by_side

log = logging.getLogger("medial.side_by_side.tests")


def test_both_run_at_once_and_messages_stay_in_order(caplog):
    second_logged = threading.Event()

    def called(name):
        if name == "first":
            assert second_logged.wait(10)  # the second is done before the first begins to log
        log.warning("begin %s", name)
        log.warning("end %s", name)
        if name == "second":
            second_logged.set()
        return name.upper()

    with caplog.at_level("WARNING"):
        assert side_by_side(called, ("first",), ("second",)) == ("FIRST", "SECOND")
    assert [r.getMessage() for r in caplog.records] == [
        "begin first",
        "end first",
        "begin second",
        "end second",
    ]
    log.warning("again")
    assert caplog.records[-1].getMessage() == "again"
    assert not log.filters


def test_error_of_the_first_is_raised_after_both_end(caplog):
    def called(name):
        log.warning("%s ran", name)
        raise ValueError(name)

    with pytest.raises(ValueError, match="first"):
        side_by_side(called, ("first",), ("second",))
    assert [r.getMessage() for r in caplog.records] == ["first ran", "second ran"]
    assert not log.filters


def test_error_of_the_second_is_raised():
    def called(name):
        if name == "second":
            raise ValueError(name)

    with pytest.raises(ValueError, match="second"):
        side_by_side(called, ("first",), ("second",))


def test_on_another_device_one_runs_after_the_other():
    called = []
    side_by_side(lambda name: called.append((name, threading.get_ident())), ("first",), ("second",), "cuda")
    here = threading.get_ident()
    assert called == [("first", here), ("second", here)]


def test_filters_of_others_see_each_message_once(caplog):
    seen = []
    log.addFilter(keep := lambda record: seen.append(record.getMessage()) or True)
    try:
        side_by_side(log.warning, ("first",), ("second",))
    finally:
        log.removeFilter(keep)
    assert sorted(seen) == ["first", "second"]
    assert [r.getMessage() for r in caplog.records] == ["first", "second"]


def test_held_messages_are_released_where_the_wait_is_interrupted(caplog, monkeypatch):
    def interrupted(self, timeout=None):
        wait(self)
        raise KeyboardInterrupt

    wait = Future.exception
    monkeypatch.setattr(Future, "exception", interrupted)
    with pytest.raises(KeyboardInterrupt):
        side_by_side(log.warning, ("first",), ("second",))
    assert [r.getMessage() for r in caplog.records] == ["first", "second"]
    assert not log.filters


def test_operators_are_those_made_one_after_the_other():
    from medial import Diffusion
    from tests.medial.posed import figure

    clouds = [figure(700), figure(900)]
    arguments = [(each.points, each.normals, "medial", 40) for each in clouds]
    alone = [Diffusion.from_points(*each) for each in arguments]
    for one, other in zip(alone, side_by_side(Diffusion.from_points, *arguments), strict=True):
        assert (one.eigenfunctions == other.eigenfunctions).all()
        assert (one.areas == other.areas).all()

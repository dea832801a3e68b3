import logging

from evaluation.experiment.tasks import Task
from evaluation.results.outcome import LONGEST_REASON, Outcome
from evaluation.running.task_warnings import MOST, gathered_warnings, repeat_warnings

HERE = logging.getLogger("medial.somewhere")


def test_warnings_are_gathered_and_not_printed(caplog, capfd):
    with gathered_warnings() as said:
        HERE.warning("%d points\nare far", 3)
        HERE.info("not worth a line")
        logging.getLogger("elsewhere").warning("not ours")
    HERE.warning("afterwards")
    assert said == [("medial.somewhere", "3 points are far")]
    assert caplog.messages == ["not ours", "afterwards"]
    assert capfd.readouterr().err == ""


def test_what_is_kept_is_bounded():
    with gathered_warnings() as said:
        for _ in range(2 * MOST):
            HERE.warning("x" * 10 * LONGEST_REASON)
    assert len(said) == MOST
    assert len(said[0][1]) == LONGEST_REASON


def test_the_driver_says_them_under_their_names(caplog):
    task = Task("key", "shape", {}, {}, "blob")
    repeat_warnings(Outcome(task, True, warnings=(("medial.somewhere", "100 % of it"),)))
    assert [(each.name, each.message) for each in caplog.records] == [("medial.somewhere", "100 % of it")]

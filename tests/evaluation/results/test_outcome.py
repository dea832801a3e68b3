"""How a task ended, in words that every file takes."""

import re

import pytest

from evaluation.experiment.tasks import Task
from evaluation.results.outcome import LONGEST_DETAIL, Outcome, one_line


@pytest.mark.parametrize("raised", [ValueError, SystemExit, KeyboardInterrupt, GeneratorExit])
def test_exceptions_that_cannot_say_why(raised):
    """One whose text asked the interpreter to exit held up the whole run."""

    class Mute(Exception):
        def __str__(self):
            raise raised(3)

    assert one_line(Mute()) == "Mute: (it cannot say why)"


def test_long_details_keep_both_ends():
    detail = "first\n" + "x" * 10**6 + "\nlast"
    kept = Outcome(Task("k", "map", {}, {}, "l"), False, "why", "error", detail=detail).detail
    assert len(kept) <= LONGEST_DETAIL
    assert kept.startswith("first\n")
    assert kept.endswith("\nlast")
    said = re.search(r"\n\.\.\. ([0-9,]+) characters left out \.\.\.\n", kept)
    assert len(detail) == len(kept) - len(said[0]) + int(said[1].replace(",", ""))

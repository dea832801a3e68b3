"""Settings of the matcher among the options of a method, as in an experiment file or after ``--set``."""

import pytest

from datasets_gen import InputError
from evaluation.methods.catalogue import create


def test_settings_by_themselves_are_settings():
    loose = create("medial", {"finalists": 4, "refine": "spectral", "settings": {"nodes": 60}})
    assert loose == create("medial", {"settings": {"nodes": 60, "finalists": 4, "refine": "spectral"}})
    assert loose.match_config().finalists == 4


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"finalist": 4}, "'finalist'; did you mean 'finalists'"),
        ({"cofnig": "paper"}, "'cofnig'; did you mean 'config'"),
        ({"finalists": 4, "settings": {"finalists": 5}}, "finalists is given twice"),
        ({"finalists": 0}, "finalists is 0"),
        ({"departures": "none"}, "departures belong to the operators"),
        ({"finalists": 4, "settings": 3}, "settings must be a table"),
    ],
)
def test_wrong_settings_are_told(options, said):
    with pytest.raises(InputError, match=said):
        create("medial", options)

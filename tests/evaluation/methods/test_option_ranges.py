"""Options of methods are checked when they are read, not hours into a sweep."""

import pytest

from datasets_gen import InputError
from evaluation.methods import create


@pytest.mark.parametrize(
    ("method", "options", "said"),
    [
        ("rigid", {"samples": 1}, "samples is 1; give a whole number of at least 4"),
        ("rigid", {"iterations": -1}, "iterations is -1"),
        ("cpd", {"beta": -1.0}, "beta must be positive"),
        ("cpd", {"alpha": 0.0}, "alpha must be positive"),
        ("cpd", {"outliers": 1.0}, "outliers must lie in"),
        ("cpd", {"samples": 9}, "samples is 9"),
        ("cpd", {"iterations": 0}, "iterations is 0"),
        ("functional-maps", {"modes": 0}, "modes is 0"),
        ("functional-maps", {"modes": 50, "final": 49}, "final is 49; give at least modes, 50"),
        ("functional-maps", {"step": 0}, "step is 0"),
        ("functional-maps", {"orientation": -1.0}, "orientation must not be negative"),
        ("geodesic-graph", {"neighbours": 0}, "neighbours is 0"),
        ("geodesic-graph", {"kept": 0}, "kept is 0"),
        ("truth-landmarks", {"landmarks": -5}, "landmarks is -5"),
        ("truth-landmarks", {"operator": "none"}, "operator"),
    ],
)
def test_what_no_method_can_work_with_is_refused(method, options, said):
    with pytest.raises(InputError, match=said):
        create(method, options)

"""Counts, seeds, types of settings and arrays that users give."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import pytest

from datasets_gen.records import InputError
from datasets_gen.values import CheckedSettings, check_count, check_seed, check_types, real_array


@dataclass(frozen=True, kw_only=True)
class Example(CheckedSettings):
    flag: bool = True
    count: int = 3
    size: float | None = 1.5
    word: Literal["a", "b"] = "a"
    names: tuple[str, ...] = ()
    kinds: tuple[Literal["a", "b"], ...] = ("a",)
    table: Mapping[str, Any] | None = None
    anything: Any = None

    def __post_init__(self):
        self.check_types()


@pytest.mark.parametrize("value", [1, 7, np.int64(7), np.uint8(1)])
def test_whole_numbers_are_counts(value):
    assert check_count(value, "points") == value
    assert type(check_count(value, "points")) is int


@pytest.mark.parametrize("value", [0, -1, 5.0, 2.5, True, np.True_, "5", None, np.arange(3), [1]])
def test_nothing_else_is_a_count(value):
    with pytest.raises(InputError, match=r"points is .*; give a whole number of at least 1"):
        check_count(value, "points")


def test_seeds_start_at_zero():
    assert check_seed(np.int32(0)) == 0
    for seed in (-1, 1.5, "x", None):
        with pytest.raises(InputError, match=r"seed is .* at least 0"):
            check_seed(seed)


@pytest.mark.parametrize(
    "values",
    [
        {"flag": False, "count": np.int64(2), "size": 2, "word": "b", "names": ["x"], "table": {}},
        {"size": np.float32(0.5), "names": (), "anything": object(), "unknown": 3},
        {"size": None, "table": None},
    ],
)
def test_values_of_the_right_type_pass(values):
    check_types(Example, values)


@pytest.mark.parametrize(
    ("name", "value", "wanted"),
    [
        ("flag", "false", "true or false, got 'false'"),
        ("flag", 1, "true or false"),
        ("count", 2.0, "a whole number"),
        ("count", True, "a whole number"),
        ("size", "x", "a finite number or None"),
        ("size", float("nan"), "a finite number"),
        ("size", 1j, "a finite number"),
        ("word", "c", "one of 'a', 'b'"),
        ("word", [], "one of 'a', 'b'"),
        ("names", "medial", "a list, each text"),
        ("names", [1], "a list, each text"),
        ("kinds", ["a", "c"], r"a list, each one of 'a', 'b', got \['a', 'c'\]"),
        ("kinds", "a", "a list, each one of 'a', 'b', got 'a'"),
        ("table", 3, "a table or None"),
    ],
)
def test_values_of_another_type_are_named(name, value, wanted):
    for make in (lambda: Example(**{name: value}), lambda: replace(Example(), **{name: value})):
        with pytest.raises(InputError, match=f"setting {name} must be {wanted}"):
            make()


def test_unknown_settings_are_named():
    for make in (lambda: Example(cuont=3), lambda: replace(Example(), cuont=3)):
        with pytest.raises(
            InputError, match=r"setting 'cuont'; did you mean 'count'\? known are flag, count"
        ):
            make()


def test_arrays_are_real():
    points = np.zeros((3, 3))
    assert real_array(points, "x") is points
    assert real_array([[1, 2]], "x").dtype == np.float64
    for given in (points + 1j, [[1j]], [[1], [1, 2]], "text", object()):
        with pytest.raises(InputError, match=r"^x (has complex|must be an array of) numbers"):
            real_array(given, "x")

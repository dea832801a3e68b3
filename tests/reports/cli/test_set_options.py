"""NAME=VALUE: what a person means by a value."""

import click
import pytest

from reports.cli.set_options import merged, parsed, value_of


@pytest.mark.parametrize(
    ("text", "value"),
    [
        (".5", 0.5),
        ("+.5", 0.5),
        ("-.5", -0.5),
        ("1.", 1.0),
        ("5e-1", 0.5),
        (".5e1", 5.0),
        ("-3", -3),
        ("0.35", 0.35),
        ("true", True),
        ("null", None),
        ("[60, 50]", [60, 50]),
        ("[[0,0,1]]", [[0, 0, 1]]),
        ('{type = "plastic"}', {"type": "plastic"}),
        ('{"type": "plastic"}', {"type": "plastic"}),
        ('"ring:3"', "ring:3"),
        ("ring:3", "ring:3"),
        (".", "."),
        ("1.2.3", "1.2.3"),
        ("e5", "e5"),
        ("[0, .5, -.5, 1.]", [0, 0.5, -0.5, 1.0]),
        ("v1.", "v1."),
        (".5.5", ".5.5"),
    ],
)
def test_values_are_what_they_look_like(text, value):
    found = value_of(text)
    assert found == value
    assert type(found) is type(value)


def test_pairs_need_a_name_and_an_equals_sign():
    assert parsed(("a=1", " b = x=y ")) == {"a": 1, "b": "x=y"}
    for pair in ("a", "=1", ""):
        with pytest.raises(click.UsageError, match="NAME=VALUE"):
            parsed((pair,))


def test_options_and_pairs_are_joined_unless_they_set_the_same():
    assert merged({"views": None, "peak_threshold": 0.3}, ("views=2",)) == {"views": 2, "peak_threshold": 0.3}
    with pytest.raises(click.UsageError, match=r"--peak-threshold 0.3.*--set peak_threshold=0.3"):
        merged({"peak_threshold": 0.3}, ("peak_threshold=.3",))

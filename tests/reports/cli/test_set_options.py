"""NAME=VALUE: what a person means by a value."""

from dataclasses import fields

import click
import pytest

from medial import MatchConfig
from reports.cli.set_options import merged, parsed, value_of
from reports.cli.setting_list import Setting, settings_of
from scanner_sim import ScannerConfig
from tests.reports.cli.command_line import fails, run


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


def test_lists_need_no_brackets_where_the_type_is_known():
    lists = [Setting("evidence", tuple[str, ...], "", ""), Setting("resolution", tuple[int, int], "", "")]
    assert parsed(("evidence=visibility,strain", "refine=a,b"), lists) == {
        "evidence": ["visibility", "strain"],
        "refine": "a,b",
    }
    assert parsed(("evidence=paths", "resolution=60, 50"), lists) == {
        "evidence": ["paths"],
        "resolution": [60, 50],
    }
    assert parsed(("evidence=",), lists) == {"evidence": []}
    assert parsed(('evidence=["paths"]',), lists) == {"evidence": ["paths"]}


def test_settings_are_listed_with_type_default_and_meaning():
    found = {each.name: each for each in settings_of(MatchConfig, ("departures",))}
    assert list(found) == [each.name for each in fields(MatchConfig) if each.name != "departures"]
    assert found["finalists"].default == "8"
    assert found["refine"].takes == "one of 'none', 'spectral', 'deform'"
    assert found["paths"].default == "true"
    assert found["evidence"].default == "visibility,strain,paths,medial"
    assert found["fine_nodes"].about == "Nodes of the final deformation"


def test_every_default_that_is_listed_is_read_back():
    for cls in (MatchConfig, ScannerConfig):
        listed = settings_of(cls, ("departures",))
        pairs = tuple(f"{each.name}={each.default}" for each in listed)
        assert cls.from_dict(parsed(pairs, listed)) == cls()


@pytest.mark.parametrize("command", ["match", "symmetry", "scan"])
def test_settings_are_listed_without_files(command):
    result = run(command, "--settings")
    assert result.exit_code == 0, result.output
    wanted = ["resolution", "400,400"] if command == "scan" else ["finalists", "'spectral'", "evidence"]
    for word in wanted:
        assert word in result.stdout
    assert "--settings" in run(command, "--help").stdout


def test_settings_of_the_method_are_listed():
    for given in (("--method", "cpd", "--settings"), ("--settings", "--method", "cpd")):
        result = run("match", *given)
        assert "outliers" in result.stdout
        assert "finalists" not in result.stdout
    fails(run("match", "--settings", "--method", "cdp"), "did you mean 'cpd'")


def test_options_and_pairs_are_joined_unless_they_set_the_same():
    assert merged({"views": None, "peak_threshold": 0.3}, ("views=2",)) == {"views": 2, "peak_threshold": 0.3}
    with pytest.raises(click.UsageError, match=r"--peak-threshold 0.3.*--set peak_threshold=0.3"):
        merged({"peak_threshold": 0.3}, ("peak_threshold=.3",))

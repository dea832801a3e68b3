"""`docs/paper.md` is true: every entry can be imported, and every equation has its function."""

import re
from dataclasses import fields
from functools import reduce
from importlib import import_module
from pathlib import Path

import pytest

from medial import Departures, MatchConfig

PAGE = (Path(__file__).resolve().parent.parent / "docs" / "paper.md").read_text(encoding="utf-8")
ROWS = [line.split("|")[1:-1] for line in PAGE.splitlines() if re.match(r"\| [0-9]", line)]
EQUATIONS = [row for row in ROWS if len(row) == 5]
DOTTED = sorted(set(re.findall(r"`((?:medial|evaluation)(?:\.\w+)+)`", PAGE)))


def found(path):
    """What a dotted path names: a module, or something in one."""
    parts = path.split(".")
    for count in range(len(parts), 0, -1):
        try:
            module = import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        return reduce(getattr, parts[count:], module)
    raise AssertionError(path)


@pytest.mark.parametrize("path", DOTTED)
def test_every_entry_can_be_imported(path):
    assert found(path).__doc__


def test_every_equation_has_one_row():
    assert [int(row[0]) for row in EQUATIONS] == list(range(1, 19))


@pytest.mark.parametrize("row", EQUATIONS, ids=lambda row: f"Eq. {row[0].strip()}")
def test_the_function_names_its_equation_and_says_what_differs(row):
    text = found(row[2].strip().strip("`")).__doc__
    assert re.match(rf"Eq\. {row[0].strip()}:", text)
    assert "In the code" in text
    assert "Parameters" in text
    assert "Returns" in text


def test_every_departure_is_listed():
    table = "".join(row[-1] for row in ROWS)
    assert not [each.name for each in fields(Departures) if f"`{each.name}`" not in table]


def test_sections_4_and_5_are_listed():
    assert {row[0].strip() for row in ROWS} >= {"4", "5.1", "5.2"}


def test_the_paper_in_one_setting():
    """The page's example runs; on fewer points."""
    snippet = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)[0]
    names = {}
    exec(snippet.replace("800)", "400)"), names)
    config = MatchConfig.paper(Departures.none())
    assert names["found"].config == names["mirror"].config == config
    assert 0 < names["error"] < 1

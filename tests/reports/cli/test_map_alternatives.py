"""Maps that may be right instead of the chosen one, on the command line."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from datasets_gen.records import InputError
from medial import Matching
from medial.matching.result import Alternative
from reports.cli.cloud_files import read_thinned
from reports.cli.map_alternatives import numbered, said_of_alternatives, write_alternatives
from reports.cli.map_options import draw_map
from tests.reports.cli.command_line import FAST, run

LINE = np.outer(np.arange(200.0), [1, 0, 0])
"""Target points one apart: the reversed order sends all but ten of 200 more than 5 % of the length away."""


@pytest.fixture
def clouds(scan_file):
    return tuple(read_thinned(scan_file, 200) for _ in range(2))


@pytest.fixture
def found():
    """The identity of 200 points, with the reversed order as a rival."""
    same = np.arange(200)
    other = Alternative(0.4, same[::-1].copy(), np.full(200, 0.3))
    return Matching(
        same, np.array([[0, 0]]), 0.0, np.full(200, 0.6), {}, probability=0.6, alternatives=(other,)
    )


@pytest.mark.parametrize(
    ("name", "second"), [("a-b.map.npz", "a-b-2.map.npz"), ("map.npz", "map-2.npz"), ("d/x.png", "d/x-2.png")]
)
def test_names_are_numbered_before_their_suffixes(name, second):
    assert numbered(Path(name), 2) == Path(second)


def test_each_alternative_is_written_and_drawn(clouds, found, tmp_path, scan_file):
    out, picture = tmp_path / "m.npz", tmp_path / "m.png"
    inputs = Path(scan_file), Path(scan_file)
    written = write_alternatives(out, picture, clouds, inputs, found, {"method": "medial"})
    assert written == [tmp_path / "m-2.npz"]
    assert (tmp_path / "m-2.png").exists()
    loaded = Matching.load(written[0])
    assert len(loaded) == 600
    kept = clouds[0].kept
    assert np.array_equal(loaded.source_to_target[kept], kept[::-1])
    assert loaded.probability == 0.4
    assert loaded.about == {"method": "medial", "alternative_to": "m.npz"}


def test_pictures_of_several_maps_say_which_one_they_show(clouds, found, tmp_path, monkeypatch):
    figures = []
    monkeypatch.setattr("reports.figures.style.save", lambda figure, *_, **__: figures.append(figure))
    for map_, name in (
        (found, {}),
        (found.as_alternatives()[0], {"name": "alternative 2"}),
        (replace(found, alternatives=(), probability=np.nan), {}),
    ):
        draw_map(tmp_path / "m.png", clouds, ("a", "b"), map_, **name)
    said = [figure.get_suptitle() for figure in figures]
    assert said == ["map, probability 0.60", "alternative 2, probability 0.40", ""]


def test_an_input_is_not_overwritten(clouds, found, tmp_path):
    inputs = tmp_path / "m-2.npz", tmp_path / "target.npz"
    inputs[0].write_bytes(b"cloud")
    with pytest.raises(InputError, match=r"m-2\.npz"):
        write_alternatives(tmp_path / "m.npz", None, clouds, inputs, found, {})
    assert inputs[0].read_bytes() == b"cloud"


def test_it_is_said_what_is_open_and_how_to_see_it(found):
    first, second, last = said_of_alternatives(found, LINE, [])
    assert first.endswith("its probability is 0.60")
    assert second == "  another one 0.40, which differs by over 5% of the target's size at 95% of the points"
    assert "--alternatives" in last
    drawn = said_of_alternatives(found, LINE, [Path("m-2.npz")], drawn=True)
    assert drawn[1] == second + "; written to m-2.npz, with its picture"
    assert len(drawn) == 2


def test_what_is_missing_to_one_is_said(found):
    lines = said_of_alternatives(replace(found, probability=0.3), LINE, [])
    assert any(line.endswith("0.30") and "none" in line for line in lines)


@pytest.mark.parametrize(("probability", "lines"), [(0.02, 2), (0.97, 0), (float("nan"), 0)])
def test_a_map_without_alternatives_is_doubted_if_it_is_unlikely(found, probability, lines):
    alone = replace(found, alternatives=(), probability=probability)
    assert len(said_of_alternatives(alone, LINE, [])) == lines


def test_the_option_writes_as_many_files_as_it_says(scan_file, tmp_path):
    result = run("match", scan_file, scan_file, "-o", tmp_path / "m.npz", "--alternatives", *FAST)
    assert result.exit_code == 0, result.output
    said = [line for line in result.stderr.splitlines() if "another one" in line]
    files = sorted(tmp_path.glob("m-*.npz"))
    assert len(files) == len(said) == len(Matching.load(tmp_path / "m.npz").alternatives)

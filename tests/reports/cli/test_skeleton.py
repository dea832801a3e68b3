"""``medialbench skeleton``."""

import json

import numpy as np
import pytest

from medial.skeletons import SKELETON_METHODS, CurveSkeleton
from medial.skeletons import local_separators as separators
from reports.cli.skeleton import METHODS
from tests.medial.clouds import planes
from tests.medial.skeletons import tubes
from tests.reports.cli.command_line import fails, run


@pytest.fixture(scope="module")
def tube(tmp_path_factory):
    path = tmp_path_factory.mktemp("clouds") / "tube.xyz"
    made = tubes.bent(500)
    np.savetxt(path, np.column_stack([made.points, made.normals]))
    return path


@pytest.mark.parametrize("method", ["rosa", "medial"])
def test_a_tube(tube, tmp_path, method):
    result = run("skeleton", tube, "-o", tmp_path / "a.npz", "--method", method)
    assert result.exit_code == 0, result.output
    assert "2 tips, 0 joints; written to" in result.stderr
    found = CurveSkeleton.load(tmp_path / "a.npz")
    assert found.method == method
    assert (found.kinds == "tip").sum() == 2
    assert len(found.node_of_point) == 500


def test_other_formats_and_all_points(tube, tmp_path):
    """Points that are not used belong to the node of the nearest one that is."""
    result = run("skeleton", tube, "-o", tmp_path / "a.json", "--points", 300, "-q")
    assert result.exit_code == 0, result.output
    assert result.output == ""
    table = json.loads((tmp_path / "a.json").read_text())
    assert len(table["node_of_point"]) == 500
    assert min(table["node_of_point"]) >= 0


def test_picture_and_page(tube, tmp_path):
    picture, page = tmp_path / "a.png", tmp_path / "a.html"
    result = run("skeleton", tube, "-o", tmp_path / "a.ply", "--picture", picture, "--view", page)
    assert result.exit_code == 0, result.output
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert "skeleton of tube.xyz" in page.read_text(encoding="utf-8")


def test_a_sheet_says_why_it_has_none(tmp_path):
    points, normals = planes(300, gap=0.03)
    np.savetxt(tmp_path / "sheet.xyz", np.column_stack([points, normals]))
    result = run("skeleton", tmp_path / "sheet.xyz", "-o", tmp_path / "a.obj")
    assert result.exit_code == 0, result.output
    assert "a flat shape has no curve skeleton; written to" in result.stderr
    assert "v " not in (tmp_path / "a.obj").read_text()


def test_failures_are_one_line(tube, tmp_path, monkeypatch):
    fails(run("skeleton", tmp_path / "none.xyz", "-o", tmp_path / "a.ply"), "none.xyz", "does not exist")
    fails(run("skeleton", tube, "-o", tmp_path / "a.stl"), "a.stl", ".ply")
    fails(run("skeleton", tube, "-o", tube.with_suffix(".ply"), "--picture", "a.gif"), "a.gif", ".png")
    monkeypatch.setattr(separators, "find_spec", lambda name: None)
    given = ("-o", tmp_path / "a.ply", "--method", "local-separators")
    fails(run("skeleton", tube, *given), "pygel3d", "pip install")
    assert list(tmp_path.iterdir()) == []


def test_the_command_offers_every_method():
    """It lists them itself, so that its help loads no libraries."""
    assert tuple(SKELETON_METHODS) == METHODS

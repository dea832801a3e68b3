"""Skeletons over clouds."""

import numpy as np
import pytest

from medial.skeletons import CurveSkeleton
from reports.figures.cloud_sheet import cloud_sheet
from reports.figures.figure_request import FigureRequest
from reports.figures.skeleton_comparison import skeleton_comparison
from reports.figures.skeleton_drawing import SKELETON_KEY, in_words, skeleton_panel
from reports.skeleton_outputs import on_skeleton
from tests.medial.skeletons import tubes

LINE = CurveSkeleton(
    np.array([[0.0, -1, 0], [0, 0, 0], [0, 1, 0]]), np.array([[0, 1], [1, 2]]), np.full(3, 0.3), np.zeros(0)
)


def test_words():
    assert in_words(LINE) == "2 tips, 0 joints, 1 part"
    assert in_words(CurveSkeleton.empty(3, "rosa", "flat")) == "no curve"


def test_every_edge_and_tip_is_drawn_where_the_camera_sees_it():
    tube = tubes.straight(300)
    panel = skeleton_panel(tube.points, tube.normals, LINE, np.eye(3), 3.0)
    sheet = cloud_sheet([[panel]], key=SKELETON_KEY)
    axes = sheet.figure.axes[0]
    rim, curve = axes.collections
    seen = panel.camera(2.5).project(LINE.nodes)[:, :2]
    assert np.allclose(curve.get_segments(), seen[LINE.edges])
    assert np.allclose(rim.get_segments(), curve.get_segments())
    tips = next(line for line in axes.lines if line.get_marker() == "o")
    assert np.allclose(tips.get_xydata(), seen[[0, 2]])


def test_points_go_to_their_places():
    points = np.array([[0.3, -0.52, 0], [0.3, 0.9, 0], [5.0, 5, 5]])
    owned = CurveSkeleton(LINE.nodes, LINE.edges, LINE.radii, np.array([1, 2, -1]))
    places = on_skeleton(owned, points)
    assert np.allclose(places[:2], [[0, -0.52, 0], [0, 0.9, 0]], atol=0.01)
    assert (places[2] == points[2]).all()


@pytest.mark.slow
@pytest.mark.long
def test_the_figure_of_the_paper():
    made = skeleton_comparison(FigureRequest(10, points=600, thresholds=(0.3,), tell=lambda words: None))
    assert {"medial diffusion source", "curve skeletons"} <= set(made.table["panel"])
    nodes = made.table[made.table["panel"] == "curve skeletons"]
    assert set(nodes["cloud"]) == {"source", "target"}
    assert {"tip", "joint"} <= set(nodes["kind"])

import numpy as np
import pytest

from reports.figures.cloud_drawing import DrawnCloud
from reports.figures.dense_map import dense_map
from reports.figures.method_comparison import MethodPanel, PairPicture, method_comparison
from reports.figures.pair_cameras import pair_cameras
from reports.figures.scan_series import ScanView, scan_series
from tests.reports.figures.test_figures import beyond_the_edge

UP = 1


def part(towards, n=400, least=0.0):
    """What of a body is seen from a direction: all of it with a `least` of -1."""
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals[normals @ np.asarray(towards, float) >= least]
    return DrawnCloud(normals * [1, 2, 0.7], normals, "a.npz")


def facing(cloud, camera):
    return float((cloud.normals @ camera.rotation[2] > 0).mean())


FRONT, BACK, WHOLE = part([0, 0, 1]), part([0, 0, -1]), part([0, 0, 1], least=-1.0)


@pytest.mark.parametrize(
    ("source", "target", "behind"),
    [
        (FRONT, FRONT, False),
        (BACK, BACK, False),
        (FRONT, WHOLE, False),
        (WHOLE, WHOLE, False),
        (FRONT, BACK, True),
        (BACK, FRONT, True),
    ],
)
def test_clouds_are_seen_from_outside_and_from_one_side_where_that_shows_both(source, target, behind):
    cameras = pair_cameras(source, target, UP, 60)
    assert cameras.behind is behind
    right, up, _ = cameras.target.rotation @ cameras.source.rotation.T
    assert up[1] > 0.9  # upright in any case
    assert right[0] == pytest.approx(-1.0 if behind else 1.0)
    least = 0.4 if any(each is WHOLE for each in (source, target)) else 0.7
    assert min(facing(source, cameras.source), facing(target, cameras.target)) > least


def test_both_clouds_lie_within_pictures_of_one_size():
    cameras = pair_cameras(FRONT, BACK, UP, 60)
    assert cameras.source.width == cameras.target.width
    assert cameras.source.scale == cameras.target.scale
    for cloud, camera in ((FRONT, cameras.source), (BACK, cameras.target)):
        columns, rows, _ = camera.project(cloud.points).T
        assert 0 <= columns.min() < columns.max() <= camera.width
        assert 0 <= rows.min() < rows.max() <= camera.height


@pytest.mark.parametrize(("target", "said"), [(BACK, "turned by 180°"), (FRONT, "")])
def test_pictures_say_that_the_target_is_seen_from_behind(target, said):
    image = np.arange(len(FRONT.points)) % len(target.points)
    sure, colors = np.ones(len(image)), np.full((len(image), 3), 0.5)
    there = np.full((len(target.points), 3), 0.5)
    panel = MethodPanel("medial", "mean 1", there, np.zeros(len(image)))
    for figure, head in (
        (dense_map(FRONT, target, image, sure, np.empty((0, 2), int), height=60), "target"),
        (method_comparison(PairPicture(FRONT, target, colors, there, (panel,)), height=60), "target, truth"),
    ):
        titles = [axes.get_title(loc="left").replace("\n", " ") for axes in figure.axes]
        assert ", ".join(filter(None, [head, said])) in titles
        assert beyond_the_edge(figure) == []


def test_scans_of_the_other_side_are_shown_from_behind():
    views = [ScanView(cloud.points, cloud.normals, "scan", "some points") for cloud in (FRONT, BACK, WHOLE)]
    figure = scan_series([("front to back", views)], height=60)
    notes = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert notes == ["some points", "some points, turned by 180°", "some points"]

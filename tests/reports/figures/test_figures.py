import io

import matplotlib as mpl
import numpy as np
import pytest

from evaluation.results.store import ResultsStore
from reports.figures.cloud_drawing import DrawnCloud
from reports.figures.dense_map import dense_map
from reports.figures.diffusion_error_curves import diffusion_error_curves
from reports.figures.error_against_missing import error_against_missing
from reports.figures.method_comparison import MethodPanel, PairPicture, method_comparison
from reports.figures.pck_curves import pck_curves
from reports.figures.scan_series import ScanView, scan_series
from reports.figures.style import method_colors, method_lines, save
from reports.method_order import METHODS, order_methods
from reports.tables.leaderboard import with_numpy_types


@pytest.fixture(scope="module")
def table(results):
    return with_numpy_types(ResultsStore(results).table())


def cloud(n=60, seed=0):
    normals = np.random.default_rng(seed).normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals * [1, 2, 0.7], normals


def lines(axes):
    return {line.get_label(): line for line in axes.get_lines()}


def test_stability_has_a_panel_per_operator_and_a_line_per_pose(table):
    rows = table[(table["kind"] == "stability") & (table["dataset"] == "blob")]
    figure = diffusion_error_curves(rows)
    panels = [axes for axes in figure.axes if axes.get_title(loc="left")]
    assert [axes.get_title(loc="left") for axes in panels] == ["medial", "heat"]
    drawn = lines(panels[1])
    assert set(drawn) == {"rest", "bent"}
    assert np.allclose(drawn["bent"].get_xydata(), [[0.3, 0.12], [0.8, 0.32]])
    assert panels[0].get_ylim()[0] == 0
    assert panels[0].get_ylim()[1] < panels[1].get_ylim()[1]  # errors of operators do not compare
    missing = [axes for axes in figure.axes if axes not in panels]
    assert np.allclose(missing[0].get_lines()[0].get_ydata(), [15, 40])  # per cent


def test_stability_has_a_row_per_number_of_views(table):
    rows = table[(table["kind"] == "stability") & (table["dataset"] == "blob")]
    import pandas as pd

    figure = diffusion_error_curves(pd.concat([rows, rows.assign(views="ring:4")]))
    titles = [axes.get_title(loc="left") for axes in figure.axes if axes.get_title(loc="left")]
    assert titles == ["medial, 6 views", "heat, 6 views", "medial, ring:4 views", "heat, ring:4 views"]


def test_pck_curves_keep_their_values_and_share_one_legend():
    radii = np.linspace(0, 25, 6)
    curves = {"a": {"heat": radii / 25, "medial": radii / 50}, "b": {"medial": radii / 50}}
    figure = pck_curves(curves, radii)
    assert np.allclose(lines(figure.axes[0])["heat"].get_ydata(), 4 * radii)
    assert list(lines(figure.axes[1])) == ["medial"]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["medial", "heat"]


def test_errors_are_shown_at_the_missing_share(table):
    figure = error_against_missing(table[table["kind"] == "matching"])
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["blob", "worm"]
    dots = [line for line in figure.axes[0].get_lines() if line.get_marker() == "."]
    assert len(dots) == 2
    assert set(np.round(dots[0].get_xdata(), 6)) == {15, 40}


def test_every_label_has_its_own_colour_and_known_methods_keep_theirs():
    labels = ["heat kernel", "medial", "medial (paper)", "mine", "zzz", "robust"]
    colors = method_colors(labels)
    assert len(set(colors.values())) == len(labels)
    assert colors["medial"] == METHODS["medial"]
    assert colors["heat kernel"] == METHODS["heat"]
    assert method_colors(["heat kernel"])["heat kernel"] == METHODS["heat"]
    assert order_methods(labels) == ["medial", "medial (paper)", "heat kernel", "robust", "mine", "zzz"]


def test_lines_of_one_colour_differ_in_their_dashes():
    labels = [f"{number} step" for number in range(20)]
    styles = method_lines(labels)
    assert list(styles) == sorted(labels)
    assert len({(style["color"], style["linestyle"]) for style in styles.values()}) == len(labels)
    assert len({style["color"] for style in styles.values()}) < len(labels)


def test_a_long_legend_leaves_the_panels_their_height():
    radii = np.linspace(0, 25, 6)

    def panel_height(methods):
        figure = pck_curves(
            {"a": {f"{k} a method with a long label": radii / 25 for k in range(methods)}}, radii
        )
        figure.draw_without_rendering()
        return figure.axes[0].get_position().height * figure.get_figheight()

    assert panel_height(20) > 0.9 * panel_height(3)


@pytest.mark.parametrize("methods", [1, 2, 7])
def test_pairs_show_all_methods(methods):
    points, normals = cloud()
    gray = np.full((len(points), 3), 0.5)
    panel = [
        MethodPanel(f"method {i}", "mean 1", gray, np.zeros(len(points)), np.array([[0, 1], [2, 3]]))
        for i in range(methods)
    ]
    side = DrawnCloud(points, normals, "a pose")
    figure = method_comparison(PairPicture(side, side, gray, gray, tuple(panel)), height=60)
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert [t for t in titles if t.startswith("method")] == [f"method {i}" for i in range(methods)]
    assert len([axes for axes in figure.axes if axes.get_images()]) == 2 + 2 * methods
    numbers = [
        text.get_text() for axes in figure.axes for text in axes.texts if text.get_text() in ("1", "2")
    ]
    assert len(numbers) == 4 * methods  # both landmarks, on both sides


def test_maps_without_truth_show_both_clouds_and_confidence():
    points, normals = cloud()
    side = DrawnCloud(points, normals, "a.npz")
    image = np.r_[-1, np.arange(1, len(points))]
    figure = dense_map(side, side, image, np.linspace(0, 1, len(points)), np.array([[1, 1]]), height=60)
    shown = [axes for axes in figure.axes if axes.get_images()]
    assert [axes.get_title(loc="left") for axes in shown] == ["source", "target", "confidence"]
    assert [[t.get_text() for t in axes.texts].count("1") for axes in shown] == [1, 1, 0]


def written(figure):
    """All texts of a figure that are seen; the ticks of pictures are not."""
    texts = [text for axes in figure.axes for text in (*axes.texts, axes._left_title)]
    texts += [label for axes in figure.axes if axes.axison for label in axes.get_yticklabels()]
    texts += [text for legend in figure.legends for text in legend.get_texts()]
    return [text for text in texts if text.get_text()]


def beyond_the_edge(figure):
    """Texts that a picture of the figure, saved as a user saves it, cuts off."""
    figure.savefig(io.BytesIO(), format="png")
    width, height = figure.bbox.size
    boxes = {text.get_text(): text.get_window_extent() for text in written(figure)}
    return [text for text, b in boxes.items() if min(b.x0, b.y0) < 0 or b.x1 > width or b.y1 > height]


@pytest.mark.parametrize("wide", [0.3, 1.0, 1.5, 2.0, 5.0])
def test_no_text_of_a_map_is_cut_off(wide):
    points, normals = cloud()
    side = DrawnCloud(points * [wide, 1, 1], normals, "a.npz")
    image = np.arange(len(points))
    figure = dense_map(side, side, image, np.linspace(0, 1, len(points)), np.array([[1, 1]]), height=60)
    assert {"source", "target", "confidence", "on the source", "1.0"} <= {
        text.get_text() for text in written(figure)
    }
    assert beyond_the_edge(figure) == []


def test_a_map_can_have_a_heading_with_room_of_its_own():
    points, normals = cloud()
    side, image = DrawnCloud(points, normals, "a.npz"), np.arange(len(points))
    figure = dense_map(
        side, side, image, np.ones(len(points)), np.array([[1, 1]]), height=60, heading="alternative 2"
    )
    assert beyond_the_edge(figure) == []
    heading, titles = figure._suptitle, [axes._left_title for axes in figure.axes[:3]]
    assert heading.get_text() == "alternative 2"
    assert heading.get_window_extent().y1 <= figure.bbox.height
    assert heading.get_window_extent().y0 > max(title.get_window_extent().y1 for title in titles)


def test_scans_have_a_row_per_pose():
    view = ScanView(*cloud(), title="τ = 0.3", note="15 % missing")
    figure = scan_series([("rest", [view, view]), ("bent", [view, view])], height=60)
    assert len([axes for axes in figure.axes if axes.get_images()]) == 4


def test_figures_are_saved_as_pdf_and_png_twice_the_same(tmp_path):
    def draw():
        return pck_curves({"a": {"medial": np.linspace(0, 1, 5)}}, np.linspace(0, 25, 5))

    for folder in ("one", "two"):
        save(draw(), tmp_path / folder, "figure")
    files = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert files == ["figure.pdf", "figure.png"]
    for name in files:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_the_callers_style_is_left_alone():
    before = dict(mpl.rcParams)
    pck_curves({"a": {"medial": np.linspace(0, 1, 5)}}, np.linspace(0, 25, 5))
    assert {**mpl.rcParams, "backend": None} == {**before, "backend": None}

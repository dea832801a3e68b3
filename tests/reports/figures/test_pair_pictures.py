import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.colors import to_rgb

from evaluation.results.store import ResultsStore
from reports.figures.cloud_drawing import ERROR_CAP, carried_colors, error_colors, position_colors
from reports.figures.pair_pictures import COUNTERPART, PairMaker, error_note, pair_picture, true_colors
from reports.figures.style import ABSENT
from reports.tables.leaderboard import with_numpy_types


def line(n):
    """n points at distance 1."""
    return np.column_stack([np.arange(n, dtype=float), np.zeros(n), np.zeros(n)])


@given(st.integers(0, 1000), st.integers(2, 40))
@settings(max_examples=30)
def test_a_bijection_carries_every_colour(seed, n):
    rng = np.random.default_rng(seed)
    image, colors = rng.permutation(n), rng.random((n, 3))
    assert np.allclose(carried_colors(image, colors, line(n))[image], colors)


def test_colours_sent_to_one_point_are_averaged():
    colors = np.array([[1.0, 0, 0], [0, 1, 0]])
    assert np.allclose(carried_colors(np.array([1, 1]), colors, line(2))[1], [0.5, 0.5, 0])


def test_points_near_a_coloured_one_are_filled_and_far_ones_stay_absent():
    found = carried_colors(np.array([0]), np.array([[1.0, 0, 0]]), line(10))
    assert np.allclose(found[:3], [1, 0, 0])  # up to 2.5 spacings
    assert np.allclose(found[3:], to_rgb(ABSENT))


def test_no_match_carries_nothing():
    found = carried_colors(np.array([-1, -1]), np.ones((2, 3)), line(4))
    assert np.allclose(found, to_rgb(ABSENT))


def test_true_colours_need_a_counterpart():
    source, target = line(3), line(5)
    colors = np.eye(3)
    found = true_colors(source, target, colors, unit=1 / COUNTERPART)  # counterparts within 1
    assert np.allclose(found[:3], colors)
    assert np.allclose(found[3], colors[2])
    assert np.allclose(found[4], to_rgb(ABSENT))


@given(st.integers(0, 1000))
@settings(max_examples=20)
def test_colours_of_places_are_valid_and_differ_where_places_do(seed):
    places = np.random.default_rng(seed).normal(size=(30, 3)) * [4, 1, 0.01]
    colors = position_colors(places, places.min(0), places.max(0))
    assert ((colors >= 0) & (colors <= 1)).all()
    far = np.array([places[:, 0].argmin(), places[:, 0].argmax()])
    assert np.linalg.norm(np.diff(colors[far], axis=0)) > 0.5


def test_error_colours_darken_and_end_at_the_cap():
    lightness = error_colors(np.linspace(0, ERROR_CAP, 50)).mean(axis=1)
    assert (np.diff(lightness) < 0).all()
    assert np.allclose(error_colors([ERROR_CAP]), error_colors([10 * ERROR_CAP]))


def test_notes_say_what_matters():
    assert (
        error_note({"geodesic_mean": 3.14, "geodesic_median": 2.0, "flipped": 0.0}) == "mean 3.1, median 2.0"
    )
    assert error_note({"geodesic_mean": 3.14, "geodesic_median": 2.0, "flipped": 1.0}).endswith("flipped")


def test_pairs_of_a_store_show_every_method(results):
    store = ResultsStore(results)
    table = with_numpy_types(store.table())
    rows = table[(table["kind"] == "matching") & (table["dataset"] == "blob") & (table["seed"] == 0)]
    pair = pair_picture(PairMaker(store).read(rows[rows["regime"] == "threshold 0.3"]))
    assert [panel.title for panel in pair.panels] == ["medial diffusion", "heat kernel"]
    assert pair.source.caption == "rest, sampled, 15 % missing"
    centers = 0.5 * pair.source.points  # what the stored operator holds
    low, high = np.quantile(centers, [0.01, 0.99], axis=0)
    assert np.allclose(pair.source_colors, position_colors(centers, low, high))
    for panel in pair.panels:
        assert panel.errors == pytest.approx(
            0, abs=1e-5
        )  # the stored maps are the identity, on equal samples
        assert np.allclose(panel.target_colors, pair.source_colors)
    assert np.allclose(pair.truth_colors, pair.source_colors)

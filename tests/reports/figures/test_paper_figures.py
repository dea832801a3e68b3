import re
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

import medialbench as mb
from datasets_gen import InputError, load
from medial import Diffusion, dual_areas
from medial.areas.dual_area import JOINED
from medial.similarity.equations import medial_similarity
from reports.figures import paper_figures
from reports.figures.dual_area_construction import dual_area_at
from reports.figures.figure_request import RESOLUTION, ScannedPose, map_errors
from reports.figures.matched_pair import MatchedPair, regional_colours
from reports.figures.quadruped_matches import signature_change
from reports.figures.signature_at_times import shoulder_vertices
from reports.figures.signature_colours import few_ticks, shared_norm
from reports.figures.similarity_against_distance import FLOOR
from reports.figures.symmetric_regions import without_band
from tests.reports.figures.made import POINTS, looked_at, make, places, request, same_kernel


@pytest.fixture(scope="module")
def human():
    return load("human")


@pytest.fixture(scope="module")
def scanned(human):
    """The scan that figures 2 and 3 are made of."""
    return ScannedPose.of(request(2), human["rest"], 0.3, 10, POINTS)


@pytest.mark.slow
@pytest.mark.long
def test_opposed_scans_map_landmarks_onto_landmarks(tmp_path):
    made = make(1)
    table = looked_at(1, made, tmp_path)
    target = table[table["panel"] == "target"].set_index("point")
    marked = table[(table["panel"] == "source") & (table["landmark"] > 0)]
    assert len(marked) >= 3
    sent = target.loc[marked["target_point"].astype(int), "landmark"].to_numpy()
    assert (sent > 0).all()
    source = table[table["panel"] == "source"]
    assert source["error"].between(0, 200).all()
    clouds = [places(table, panel)[0] for panel in ("source", "target")]
    facing = [cloud[:, 2].mean() for cloud in clouds]
    assert facing[0] > facing[1]  # the source is the front, the target the back


def test_similarities_and_distances_are_those_of_the_equations(scanned, tmp_path):
    table = looked_at(2, make(2), tmp_path)
    assert len(table) > 100
    expected = medial_similarity(table["gamma"].to_numpy(), table["tau"].to_numpy())
    assert np.allclose(table["phi"], expected, rtol=1e-3, atol=1e-5)
    assert (table["phi"] >= FLOOR).all()
    i, j = table["i"].to_numpy(), table["j"].to_numpy()
    gap = np.linalg.norm(scanned.diffusion.centers[i] - scanned.diffusion.centers[j], axis=1)
    assert np.allclose(table["medial_distance"], gap)
    phi = mb_similarity(scanned)
    assert np.allclose(table["phi"], phi[i, j])


def mb_similarity(each):
    from medial import density_weights, similarity, surface_areas

    points, normals = each.scan.points, each.diffusion.normals
    weights = density_weights(surface_areas(points, normals))
    return similarity(points, normals, weights=weights).toarray()


def test_the_construction_gives_the_dual_areas_of_the_operator(scanned):
    found = scanned.diffusion
    areas = dual_areas(found.points, found.centers, found.radii, found.normals, nearest=JOINED)
    shown = {i: dual_area_at(scanned, i) for i in range(0, POINTS, 15)}
    kinds = {each.projected for each in shown.values() if each}
    assert kinds == {False, True}
    for i, each in shown.items():
        if each is not None:
            assert each.area == pytest.approx(areas[i], rel=1e-6)


def test_the_dual_area_figure_shows_a_third_of_the_triangles(tmp_path):
    table = looked_at(3, make(3), tmp_path)
    own = table[table["is_p"]].iloc[0]
    assert own["triangles_at_p"] == pytest.approx(3 * own["dual_area_of_p"])
    assert table["projected"].nunique() == 1


def test_curves_and_profile_are_the_kernel_of_a_point_with_itself(tmp_path):
    from scanner_sim import sample

    table = looked_at(4, make(4), tmp_path)
    body = load("capsule_chain")
    cloud = sample(body["straight"], POINTS, 0)
    diffusion = Diffusion.from_points(cloud.points, cloud.normals, modes=POINTS // 4)
    for _, row in table.groupby("panel").sample(5, random_state=0).iterrows():
        expected = body.reference.area * same_kernel(diffusion, int(row["point"]), row["time"])
        assert row["area_m_t"] == pytest.approx(expected, rel=1e-6)
    marked = table[table["panel"] == "over time"].drop_duplicates("name")["point"]
    assert (np.diff(diffusion.radii[marked]) < 0).all()  # from the largest ball to the smallest


def test_the_signature_is_shown_on_mirrored_shoulders(human, tmp_path):
    table = looked_at(5, make(5), tmp_path)
    left, right = shoulder_vertices(human)
    assert human.mirror[left] == right
    assert human.reference.vertices[left, 0] > 0 > human.reference.vertices[right, 0]
    for name in ("L", "R"):
        assert (table["shoulder"] == name).sum() == 3  # poses
    one = table[table["cloud"] == "human/rest"]
    points = one[["x", "y", "z"]].to_numpy()
    pose = ScannedPose.of(request(5), human["rest"], 0.1, 10, POINTS)
    assert np.allclose(points, pose.scan.points)
    expected = human.reference.area * same_kernel(pose.diffusion, 7, one["t_9"].iloc[0])
    assert one["area_m_t_9"].iloc[7] == pytest.approx(expected, rel=1e-5)


def test_eq18_is_that_of_the_evaluation(human, tmp_path):
    table = looked_at(6, make(6, poses=("walk",), thresholds=(0.3, 0.8), points=500), tmp_path)
    assert list(table["threshold"]) == [0.3, 0.8]
    whole = mb.scan(human["walk"], threshold=0.3, views=6, resolution=RESOLUTION)
    scan = whole.accept(0.8).subsample(500)
    expected = mb.diffusion_error(scan, human, modes=500 // 4)
    assert table["eq18"].iloc[1] == pytest.approx(expected, rel=1e-6)
    assert table["missing"].iloc[0] < table["missing"].iloc[1]


@pytest.mark.slow
@pytest.mark.long
def test_symmetries_have_a_body_with_a_part_of_its_own(tmp_path):
    made = make(7, dataset="human", poses=("walk",), points=3000)
    table = looked_at(7, made, tmp_path)
    assert table["image"].between(0, len(table) - 1).all()
    foot = table[table["part"] == 1]
    assert len(foot) > 20
    images = table.loc[foot["image"], "y"]
    assert images.mean() < 0.3 * table["y"].max()  # the other foot, not the other end of the body
    assert table["line"].any()


def test_a_band_of_a_limb_is_taken_out():
    body = load("quadruped")
    scan = mb.sample(body["stand"], 3000)
    cut = without_band(body, scan)
    lost = 1 - len(cut) / len(scan)
    assert 0.002 < lost < 0.1
    gone = scan.points[~np.isin(scan.points[:, 0], cut.points[:, 0])]
    assert np.ptp(gone[:, 2]) < 0.5 * np.ptp(scan.points[:, 2])  # of one place along the body


@pytest.mark.slow
def test_matches_of_humans_show_pairs(human, tmp_path):
    table = looked_at(8, make(8, poses=("rest", "tpose")), tmp_path)
    assert set(table["panel"]) == {"pair 1 source", "pair 1 target"}
    with pytest.raises(InputError, match="even number"):
        make(8, poses=("rest", "tpose", "walk"))


def test_the_change_of_the_signature_is_a_mean_of_logarithms():
    here, there = np.array([[1.0, 2.0], [3.0, 3.0]]), np.array([[2.0, 2.0]])
    found = signature_change(here, there, np.array([0, -1]))
    assert found[0] == pytest.approx(np.log(2) / 2)
    assert np.isnan(found[1])


@pytest.mark.slow
@pytest.mark.long
def test_matches_of_quadrupeds_have_an_inset_of_the_signature(tmp_path):
    table = looked_at(9, make(9), tmp_path)
    assert table["signature"].notna().all()
    assert table.loc[table["panel"] == "source", "signature_change"].notna().all()


@pytest.mark.slow
@pytest.mark.long
def test_heat_kernel_and_medial_diffusion_get_both_matchers(tmp_path):
    table = looked_at(11, make(11), tmp_path)
    assert table["panel"].nunique() == 8  # two operators, two matchers, source and target


def test_errors_of_a_map_are_those_of_the_public_call(human):
    one, other = (ScannedPose.of(request(8), human[pose], 0.3, 6, POINTS) for pose in ("rest", "walk"))
    image = np.arange(POINTS)[::-1].copy()
    from evaluation.methods import dense

    found = dense(image, np.ones(POINTS))
    expected = mb.geodesic_error(found, one.scan, other.scan, human)
    assert np.allclose(map_errors(human, one, other, image), expected)
    pair = MatchedPair(human, one, other, found, expected)
    least = mb.score(found, one.scan, other.scan, human).least
    assert pair.least_mean == pytest.approx(100 * least)
    assert f"{100 * least:.1f}" in pair.chance_words
    assert "probability" not in pair.chance_words  # of a method that knows none
    sure = MatchedPair(human, one, other, replace(found, probability=0.25), expected)
    assert sure.chance_words.endswith("probability of the map 0.25")


def test_points_of_one_medial_ball_share_a_colour(scanned):
    target = scanned
    image = np.full(POINTS, -1)
    image[0] = 5
    colors = np.tile([1.0, 0.0, 0.0], (POINTS, 1))
    found = regional_colours(image, colors, target)
    gap = np.linalg.norm(target.diffusion.centers - target.diffusion.centers[5], axis=1)
    near = gap < 0.5 * target.diffusion.radii
    assert np.allclose(found[near], [1, 0, 0])
    assert not np.allclose(found[gap.argmax()], [1, 0, 0])


def test_shared_scales_hold_all_values_and_have_round_ticks():
    norm = shared_norm([np.geomspace(1, 10, 100), np.geomspace(5, 100, 100)])
    assert norm.vmin < 1.5
    assert norm.vmax > 80
    assert few_ticks(norm) == [10.0] or set(few_ticks(norm)) <= {3.0, 10.0, 30.0, 2.0, 5.0, 20.0, 50.0}


@pytest.mark.parametrize(
    ("number", "chosen", "words"),
    [
        (5, {"dataset": "human_asymmetric"}, "mirror"),
        (9, {"poses": ("stand",)}, "2 poses"),
        (4, {"poses": ("nowhere",)}, "no pose 'nowhere'"),
        (1, {"thresholds": (0.3, 0.5)}, "one threshold"),
        (12, {}, "no figure 12"),
    ],
    ids=["no mirror map", "one pose", "unknown pose", "two thresholds", "unknown figure"],
)
def test_what_a_figure_lacks_is_said_in_a_line(number, chosen, words):
    with pytest.raises(InputError, match=re.escape(words)) as error:
        make(number, **chosen)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("number", paper_figures.FIGURES)
def test_every_figure_of_the_table_has_a_module(number):
    name = paper_figures.FIGURES[number].name
    assert callable(getattr(import_module(f"reports.figures.{name}"), name))


@pytest.mark.parametrize("chosen", [{"points": 5}, {"seed": -1}, {"thresholds": (1.5,)}], ids=str)
def test_numbers_out_of_range_are_refused(chosen):
    with pytest.raises(InputError):
        request(1, **chosen)

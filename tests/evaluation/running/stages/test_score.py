"""Scores of maps that are known: the true one, its mirror image and none."""

from dataclasses import replace

import numpy as np
import pytest

from datasets_gen import load
from evaluation.methods import dense
from evaluation.running.stages.interface import Inputs
from evaluation.running.stages.score import score_map
from medial import Diffusion
from medial.matching.result import Alternative
from scanner_sim import sample

SPEC = {"evaluated": 400, "seed": 0}


@pytest.fixture(scope="module")
def human():
    return load("human")


DERIVED = {}
"""What was derived from records that are in it too, so that none gives its place to another."""


def derived(record, function):
    """What a function makes of a record, made once as in a worker."""
    key = id(record), function.__qualname__
    if key not in DERIVED:
        DERIVED[key] = record, function(record)
    return DERIVED[key][1]


def scored(collection, source, target, found):
    """The row of a map; medial centres of the reference are halfway to the body's axis."""
    ideal = sample(collection.reference, 1000, seed=9)
    flat = Diffusion(
        points=ideal.points,
        normals=ideal.normals,
        areas=np.ones(len(ideal)),
        eigenvalues=np.zeros(1),
        eigenfunctions=np.ones((len(ideal), 1)),
        centers=ideal.points * [0.5, 1, 0.5],
        radii=np.ones(len(ideal)),
        operator="medial",
    )
    records = {"shape": collection, "source_scan": source, "target_scan": target, "map": found}
    records["reference_medial"] = flat
    inputs = Inputs(
        keys={},
        load=records.__getitem__,
        note=lambda role: {"missing": 0.0},
        derive=lambda role, function: derived(records[role], function),
    )
    return score_map(SPEC, inputs).info["row"]


def nearest(places, others):
    return np.linalg.norm(places[:, None] - others[None], axis=2).argmin(axis=1)


@pytest.fixture(scope="module")
def pair(human):
    return sample(human.reference, 800, seed=1), sample(human.reference, 800, seed=2)


def test_the_best_map_has_next_to_no_excess_and_every_limb(human, pair):
    source, target = pair
    best = nearest(source.true_points, target.true_points)
    row = scored(human, source, target, dense(best, np.ones(800)))
    assert 0 <= row["excess_mean"] < 0.2  # nearest in space is nearly nearest on the surface
    assert row["oracle_mean"] + row["excess_mean"] == pytest.approx(row["geodesic_mean"])
    assert (row["right_limb"], row["mirror_limb"], row["gross"]) == (1, 0, False)
    assert row["sure_right"] == 1


def test_the_mirrored_map_has_the_other_limb_of_every_pair(human, pair):
    source, target = pair
    mirrored = nearest(source.true_points * [-1, 1, 1], target.true_points)
    row = scored(human, source, target, dense(mirrored, np.full(800, 0.5)))
    assert (row["right_limb"], row["mirror_limb"]) == (pytest.approx(1 / 5), 1)  # the head stays
    assert (row["gross"], row["flipped"], row["sure_right"]) == (True, True, None)
    assert row["medial_path_mean"] > 1.2 * row["medial_mean"]
    assert row["excess_mean"] > 15


def test_the_best_of_all_is_an_alternative_where_that_is_better(human, pair):
    source, target = pair
    best = nearest(source.true_points, target.true_points)
    mirrored = nearest(source.true_points * [-1, 1, 1], target.true_points)
    right, wrong = (dense(each, np.ones(800)) for each in (best, mirrored))
    alone = [scored(human, source, target, each) for each in (right, wrong)]
    assert [row["geodesic_best"] for row in alone] == [row["geodesic_mean"] for row in alone]
    assert [(row["alternatives"], row["probability"]) for row in alone] == [(0, None), (0, None)]

    def with_other(chosen, other):
        others = (Alternative(0.3, other.source_to_target, other.confidence),)
        return replace(chosen, probability=0.6, alternatives=others)

    for chosen, other, row in ((right, wrong, alone[0]), (wrong, right, alone[1])):
        found = scored(human, source, target, with_other(chosen, other))
        assert (found["alternatives"], found["probability"]) == (1, 0.6)
        assert found["geodesic_mean"] == row["geodesic_mean"]
        assert found["geodesic_best"] == alone[0]["geodesic_mean"]


def test_without_the_mirror_map_nothing_is_said_of_mirror_images(human, pair):
    source, target = pair
    best = nearest(source.true_points, target.true_points)
    row = scored(replace(human, mirror=None), source, target, dense(best, np.ones(800)))
    assert (row["right_limb"], row["mirror_limb"], row["flipped"]) == (1, None, None)


def test_points_without_a_match_cost_what_a_random_match_costs(human, pair):
    source, target = pair
    best = nearest(source.true_points, target.true_points)
    drawn = np.random.default_rng(0).integers(800, size=(3, 800))
    guesses = [scored(human, source, target, dense(each, np.ones(800))) for each in drawn]
    nothing = scored(human, source, target, dense(np.full(800, -1), np.ones(800)))
    for name in ("geodesic_mean", "excess_mean", "medial_mean", "medial_path_mean", "geodesic_median"):
        assert nothing[name] == pytest.approx(np.mean([each[name] for each in guesses]), rel=0.1)
    assert nothing["oracle_mean"] == guesses[0]["oracle_mean"] > 0  # of all points, whatever the map
    assert (nothing["matched"], nothing["gross"], nothing["right_limb"]) == (0, True, 0)
    assert (nothing["pck_auc"], nothing["distinct"], nothing["flipped"], nothing["sure_right"]) == (
        0,
        0,
        None,
        None,
    )
    half = np.where(source.true_points[:, 1] > 1, best, -1)
    row = scored(human, source, target, dense(half, np.ones(800)))
    assert row["matched"] == pytest.approx((half >= 0).mean(), abs=0.1)
    unmatched = 1 - row["matched"]
    assert row["geodesic_mean"] > 0.8 * unmatched * nothing["geodesic_mean"]
    assert row["oracle_mean"] + row["excess_mean"] == pytest.approx(row["geodesic_mean"])


@pytest.mark.parametrize("share", [0.02, 0.5, 0.9])
def test_leaving_out_the_worst_points_of_a_bad_map_is_no_better_than_a_good_map(human, pair, share):
    """Only the points that are right by luck are matched, as a method might that knows which these are."""
    source, target = pair
    best = nearest(source.true_points, target.true_points)
    kept = np.random.default_rng(0).random(800) < share
    sly = scored(human, source, target, dense(np.where(kept, best, -1), np.ones(800)))
    fair = scored(human, source, target, dense(best, np.ones(800)))
    for name in (
        "geodesic_mean",
        "geodesic_symmetric_mean",
        "excess_mean",
        "medial_mean",
        "medial_path_mean",
    ):
        assert sly[name] > fair[name] + 1

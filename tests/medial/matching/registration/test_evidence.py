"""What speaks for a map."""

from dataclasses import asdict

import numpy as np
import pytest

from medial.matching.registration.evidence import (
    KINDS,
    WEIGHTS,
    Weights,
    likelihood_of_none,
    likelihood_of_other_limbs,
    log_likelihood,
    medial_gap,
    probabilities,
    promise,
)

RANDOM = np.random.default_rng(0)
CENTERS, RADII = RANDOM.normal(size=(60, 3)), RANDOM.uniform(0.1, 0.2, 60)


def gap_by_loops(centers, radii, others, other_radii):
    """Sum of both mean distances to the nearest ball, one pair at a time."""
    square = [
        [((c - d) ** 2).sum() + (r - s) ** 2 for d, s in zip(others, other_radii, strict=True)]
        for c, r in zip(centers, radii, strict=True)
    ]
    apart = np.sqrt(square)
    return apart.min(axis=1).mean() + apart.min(axis=0).mean()


def test_all_kinds_together_are_the_default():
    assert Weights.of(KINDS) == WEIGHTS == Weights()


@pytest.mark.parametrize(
    ("kind", "gone"),
    [
        ("visibility", set()),
        ("strain", {"strain", "held", "fine_strain"}),
        ("paths", {"paths", "mirrored_paths"}),
        ("medial", {"medial", "quick_medial"}),
    ],
)
def test_what_is_left_out_weighs_nothing(kind, gone):
    left = asdict(Weights.of([k for k in KINDS if k != kind]))
    assert {name for name, value in left.items() if value == 0} == gone
    assert all(value == getattr(WEIGHTS, name) for name, value in left.items() if name not in gone)


def test_likelihood_falls_with_each_cost_and_rises_with_the_score():
    at = log_likelihood(WEIGHTS, 1.0, 2e-4, 0.05, 0.3)
    assert log_likelihood(WEIGHTS, 1.1, 2e-4, 0.05, 0.3) == pytest.approx(at + 0.1 * WEIGHTS.score)
    assert log_likelihood(WEIGHTS, 1.0, 3e-4, 0.05, 0.3) == pytest.approx(at - 1e-4 * WEIGHTS.fine_strain)
    assert log_likelihood(WEIGHTS, 1.0, 2e-4, 0.15, 0.3) == pytest.approx(at - 0.1 * WEIGHTS.medial)
    assert log_likelihood(WEIGHTS, 1.0, 2e-4, 0.05, 0.4) == pytest.approx(at - 0.1 * WEIGHTS.fine_missed)


def test_likelihood_is_a_weighted_sum():
    weights = Weights(score=3.0, fine_strain=70.0, medial=5.0, fine_missed=0.5)
    assert log_likelihood(weights, 2.0, 0.01, 0.3, 0.9) == pytest.approx(6 - 0.7 - 1.5 - 0.45)


def test_promise_rises_with_the_score_and_falls_with_the_gap():
    weights = Weights(quick_score=20.0, quick_medial=3.0)
    assert promise(weights, 2.0, 0.5) == pytest.approx(38.5)


def test_the_same_balls_have_no_gap_and_others_that_of_their_nearest():
    others, radii = CENTERS[:25] + 0.05, RADII[:25]
    assert medial_gap(CENTERS, RADII, CENTERS, RADII) == 0
    found = medial_gap(CENTERS, RADII, others, radii)
    assert found == pytest.approx(gap_by_loops(CENTERS, RADII, others, radii))
    assert found == pytest.approx(medial_gap(others, radii, CENTERS, RADII))


def test_balls_of_one_limb_meet_from_whichever_side_it_was_scanned():
    """A cylinder of radius r: the centres of points in front and of points behind are its axis."""
    angle, height = RANDOM.uniform(0, np.pi, 200), RANDOM.uniform(0, 1, 200)
    axis = np.column_stack([0 * height, 0 * height, height])
    front = axis + 0.1 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    behind = front * [1, -1, 1]
    radius = np.full(200, 0.1)
    centers = [side - 0.1 * (side - axis) / 0.1 for side in (front, behind)]
    assert medial_gap(centers[0], radius, centers[1], radius) < 1e-12
    assert medial_gap(front, radius, behind, radius) > 0.1


def test_surface_operators_have_no_medial_balls():
    assert medial_gap(CENTERS, 0 * RADII, CENTERS + 1, 0 * RADII) == 0
    assert medial_gap(CENTERS, RADII, CENTERS + 1, 0 * RADII) == 0
    assert medial_gap(CENTERS, 0 * RADII, CENTERS + 1, RADII) == 0


def test_probabilities_add_up_and_do_not_overflow():
    share = probabilities(np.array([1000.0, 1000.0, 999.0, -1e6]), 1.0)
    assert share.sum() == pytest.approx(1)
    assert share[0] == share[1] == pytest.approx(np.e * share[2])
    assert share[3] == 0


def test_where_every_map_is_unlikely_none_is_probable():
    assert probabilities(np.array([2.5]), 2.5)[0] == 0.5
    assert probabilities(np.array([-30.0, -31.0]), 1.0).sum() < 1e-10


def test_the_more_meets_the_likelier_a_right_map_has_to_be():
    weights = Weights(none=-2.0, none_seen=3.0)
    assert likelihood_of_none(weights, 0.0) == -2
    assert likelihood_of_none(weights, 1.5) == pytest.approx(2.5)


@pytest.mark.parametrize("best", [-20.0, 4.0, 30.0])
def test_where_limbs_of_the_other_side_fit_as_well_no_map_is_likelier_than_not(best):
    without = probabilities(np.array([best, best - 3]), 4.0)
    found = probabilities(np.array([best, best - 3]), likelihood_of_other_limbs(4.0, best))
    assert found[0] < 0.5
    assert found[0] / (1 - found[0]) == pytest.approx(without[0])
    np.testing.assert_allclose(found[0] / found[1], np.exp(3))

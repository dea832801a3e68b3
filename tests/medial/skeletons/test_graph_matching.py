"""Skeletons drawn by hand, matched by path lengths and radii."""

import numpy as np
import pytest

from medial.skeletons import CurveSkeleton
from medial.skeletons.graph_matching import carried_places, matched_tips
from medial.skeletons.skeleton_paths import SkeletonPaths

LIMBS = {"long": 3.0, "middle": 2.0, "short": 1.0}


def star(directions, lengths, radii=(0.1, 0.1, 0.1), without=()):
    """Limbs from the origin; node 0 is the joint, node k + 1 the tip of limb k."""
    kept = [k for k in range(3) if k not in without]
    tips = np.array([lengths[k] * np.asarray(directions[k], float) for k in kept])
    nodes = np.vstack([np.zeros((1, 3)), tips])
    edges = np.array([[0, k + 1] for k in range(len(kept))])
    thick = np.array([0.1, *(radii[k] for k in kept)])
    return SkeletonPaths.of(CurveSkeleton(nodes, edges, thick, np.arange(len(nodes))), nodes)


FIRST = star(np.eye(3), [3, 2, 1])
OTHER = star(-np.eye(3)[[1, 2, 0]], [3, 2, 1])


def test_path_lengths_are_those_along_the_limbs():
    assert FIRST.lengths[1, 2] * FIRST.unit == pytest.approx(5)
    assert FIRST.lengths[1, 3] * FIRST.unit == pytest.approx(4)
    assert FIRST.lengths[0, 3] * FIRST.unit == pytest.approx(1)
    assert FIRST.lengths.mean() == pytest.approx(1)
    assert FIRST.of_point.tolist() == [0, 1, 2, 3]


def test_tips_of_equal_limbs_belong_together_in_any_pose():
    best = matched_tips(FIRST, OTHER, 1)[0]
    assert sorted(map(tuple, best.pairs[: best.tips].tolist())) == [(1, 1), (2, 2), (3, 3)]
    assert best.pairs[best.tips :].tolist() == [[0, 0]]
    assert best.cost == pytest.approx(0, abs=1e-9)


def test_equal_limbs_are_told_apart_by_their_radii():
    thick = star(np.eye(3), [2, 2, 2], (0.1, 0.3, 0.6))
    turned = star(np.eye(3), [2, 2, 2], (0.6, 0.1, 0.3))
    best = matched_tips(thick, turned, 1)[0]
    assert sorted(map(tuple, best.pairs[: best.tips].tolist())) == [(1, 2), (2, 3), (3, 1)]


def test_places_along_limbs_follow_their_path_lengths():
    image, residual = carried_places(FIRST, OTHER, matched_tips(FIRST, OTHER, 1)[0].pairs)
    assert residual.max() < 0.02
    away = np.linalg.norm(FIRST.places, axis=1), np.linalg.norm(OTHER.places[image], axis=1)
    assert away[0] == pytest.approx(away[1], abs=0.06)


def test_a_missing_limb_leaves_a_tip_without_a_partner():
    """Thick and thin limbs are still told apart; the unit, which is the skeleton's own, is another one."""
    radii = (0.1, 0.5, 0.9)
    whole = star(np.eye(3), [3, 2, 1], radii)
    lacking = star(-np.eye(3)[[1, 2, 0]], [3, 2, 1], radii, without=[2])
    best = matched_tips(whole, lacking, 1)[0]
    assert sorted(map(tuple, best.pairs[: best.tips].tolist())) == [(1, 1), (2, 2)]

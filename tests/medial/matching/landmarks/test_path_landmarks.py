"""Medial path lengths, and the landmark sets that agree in them."""

import numpy as np
import pytest

from medial import Diffusion
from medial.matching.common_units import CloudInUnits, common_units
from medial.matching.landmarks.medial_paths import CHANGED, FAR, MedialPaths, path_distortion
from medial.matching.landmarks.path_landmarks import (
    NONE,
    SearchConfig,
    distinct_states,
    extrapolate_by_paths,
    landmark_sets,
)
from tests.medial.clouds import body, cylinder, torus
from tests.medial.matching_shapes import lobes
from tests.medial.posed import bent, figure, left_arm, legs, right_arm

TWINS = (  # mirrored in x = 0, and in nothing else
    ((0, 0, -0.6), (0, 0, 0.9), 0.3),
    ((0, 0, 0.4), (1.1, 0.3, 0.6), 0.2),
    ((0, 0, 0.4), (-1.1, 0.3, 0.6), 0.2),
    ((0, 0, -0.6), (0.4, -0.2, -1.3), 0.22),
    ((0, 0, -0.6), (-0.4, -0.2, -1.3), 0.22),
)


def paths_of(diffusion, count=300):
    return MedialPaths.of(common_units(diffusion, diffusion)[0], count)


@pytest.fixture(scope="module")
def cloud():
    return common_units(figure(), figure())[0]


@pytest.fixture(scope="module")
def paths(cloud):
    return MedialPaths.of(cloud, 300)


def tube(n=800, radius=0.3, length=2.0):
    points, normals = cylinder(n, radius, length)
    return CloudInUnits(points, normals, points - radius * normals, np.full(n, radius))


def test_path_lengths_on_a_ring_are_arcs_of_its_circle():
    """Of radius 1, whichever side of the tube a point is on; both ways round."""
    points, normals = torus(900)
    ring = points * [1, 1, 0]
    centers = ring / np.linalg.norm(ring, axis=1, keepdims=True)
    paths = MedialPaths.of(CloudInUnits(points, normals, centers, np.full(900, 0.3)), 300)
    assert np.allclose(paths.lengths, paths.lengths.T)
    place = centers[paths.nodes]
    arcs = np.arccos(np.clip(place @ place.T, -1, 1))
    far = arcs > 0.5
    assert far.mean() > 0.8
    assert paths.lengths[far] == pytest.approx(arcs[far], rel=0.1)
    assert np.median(paths.lengths[far] / arcs[far]) == pytest.approx(1, abs=0.04)


def test_the_length_of_a_tube_is_that_of_its_axis():
    paths = MedialPaths.of(tube(), 300)
    height = tube().points[paths.nodes, 2]
    tips = paths.lengths[height.argmin(), height.argmax()]
    assert tips == pytest.approx(height.max() - height.min(), rel=0.06)
    start = paths.lengths[height.argmin()]
    assert np.abs(start - (height - height.min())).max() < 0.12  # all around, not along the surface


def test_bending_leaves_path_lengths_alone(cloud, paths):
    unit = np.linalg.norm(figure().points[0]) / np.linalg.norm(cloud.points[0])
    points, normals = bent(figure().points, figure().normals, 1.2)
    centers = bent(figure().centers, figure().normals, 1.2)[0]
    posed = MedialPaths.of(CloudInUnits(points / unit, normals, centers / unit, cloud.radii), 300)
    both, here, there = np.intersect1d(paths.nodes, posed.nodes, return_indices=True)
    assert len(both) > 50
    before, after = (p.lengths[np.ix_(k, k)] for p, k in ((paths, here), (posed, there)))
    assert np.abs(before - after).max() < 0.08
    straight = [np.linalg.norm(x[both][:, None] - x[both], axis=2) for x in (cloud.points, points / unit)]
    assert np.abs(straight[0] - straight[1]).max() > 0.15  # while straight lines do change


def test_path_distortion_is_the_mean_change_over_far_pairs(cloud, paths):
    rng = np.random.default_rng(0)
    points, matches = rng.integers(len(cloud), size=(2, 30))
    changes = []
    for a, b in zip(points, matches, strict=True):
        for c, d in zip(points, matches, strict=True):
            before = paths.lengths[paths.nearest[a], paths.nearest[c]]
            after = paths.lengths[paths.nearest[b], paths.nearest[d]]
            if before >= FAR:
                changes.append(min(abs(after - before), CHANGED))
    assert path_distortion(paths, paths, points, matches) == pytest.approx(np.mean(changes))


def test_the_right_map_changes_no_path_and_a_swapped_limb_does(cloud, paths):
    points = figure().points
    some = np.arange(0, len(points), 3)
    assert path_distortion(paths, paths, some, some) == 0
    swapped = some.copy()
    arms = right_arm(points[some]), left_arm(points[some])
    swapped[arms[0]], swapped[arms[1]] = np.flatnonzero(left_arm(points))[0], np.flatnonzero(legs(points))[0]
    assert path_distortion(paths, paths, some, swapped) > 0.01


def test_no_two_points_far_apart_are_no_evidence(paths):
    assert path_distortion(paths, paths, np.zeros(3, dtype=np.int64), np.arange(3)) == 0


def test_two_components_are_joined():
    one = tube(300)
    both = [np.concatenate([x, x + np.array([3.0, 0, 0])]) for x in (one.points, one.centers)]
    normals = np.tile(one.normals, (2, 1))
    paths = MedialPaths.of(CloudInUnits(both[0], normals, both[1], np.full(600, 0.3)), 200)
    assert np.isfinite(paths.lengths).all()
    right = paths.nodes >= 300
    assert paths.lengths[right][:, ~right].min() > 2


def test_nodes_stand_for_the_points_around_them(cloud, paths):
    assert np.array_equal(paths.nearest[paths.nodes], np.arange(300))
    gap = np.linalg.norm(cloud.points - cloud.points[paths.nodes[paths.nearest]], axis=1)
    assert gap.max() < 0.15
    assert np.array_equal(paths.radii, cloud.radii[paths.nodes])


def test_far_apart_takes_the_tips_first(cloud, paths):
    order = paths.far_apart(5)
    assert len(np.unique(order)) == 5
    tips = cloud.points[paths.nodes[order]] * np.sqrt(figure().areas.sum())
    ends = np.array([[0.95, 0.1, 0.5], [-0.8, 0.3, 0], [0.25, 0.1, -1.2], [-0.35, -0.2, -1.15]])
    assert (np.linalg.norm(ends[:, None] - tips, axis=2).min(axis=1) < 0.2).all()
    gaps = [paths.lengths[order[k], order[:k]].min() for k in range(1, 5)]
    assert gaps == sorted(gaps, reverse=True)


def test_a_shape_agrees_with_itself(paths):
    sets = landmark_sets(paths, paths)
    assert np.array_equal(sets[0].source, sets[0].target)
    assert sets[0].cost == pytest.approx(0, abs=1e-9)
    assert 1 < len(sets) <= SearchConfig().sets
    costs = [each.cost for each in sets]
    assert costs == sorted(costs)
    assert costs[1] > 0


def test_landmark_sets_are_kept_apart(paths):
    sets = landmark_sets(paths, paths, SearchConfig(width=40, sets=10))
    assert len(sets) > 2
    for k, first in enumerate(sets):
        for second in sets[k + 1 :]:
            both = (first.target != NONE) & (second.target != NONE)
            gone = (first.target == NONE) != (second.target == NONE)
            gap = paths.lengths[first.target[both], second.target[both]]
            assert gone.any() or gap.max() >= SearchConfig().apart


def test_the_mirrored_set_of_a_symmetric_shape_is_kept():
    points, normals = lobes(TWINS)
    paths = paths_of(Diffusion.from_points(points, normals, modes=40))
    places = points[paths.nodes]
    mirrored, same = [], []
    for each in landmark_sets(paths, paths):
        if (each.target != NONE).all():
            gap = places[each.target][:, None] - places[each.source][:, None] * [[[1, 1, 1], [-1, 1, 1]]]
            same_gap, mirror_gap = np.linalg.norm(gap, axis=2).max(axis=0)
            same.append(same_gap < 0.25)
            mirrored.append(mirror_gap < 0.5)
    assert same[0]
    assert any(mirrored)
    assert not mirrored[0]


def test_a_landmark_without_counterpart_has_no_partner():
    points, normals = body(700)
    kept = points[:, 0] < 0.35
    cut = Diffusion.from_points(points[kept], normals[kept], modes=60)
    here, there = (MedialPaths.of(cloud, 300) for cloud in common_units(figure(), cut))
    best = landmark_sets(here, there)[0]
    hand = figure().points[here.nodes[best.source], 0] > 0.7
    assert hand.any()
    assert (best.target[hand] == NONE).all()
    assert (best.target[~hand] != NONE).mean() > 0.6


def test_identical_landmarks_spread_to_the_identity(paths):
    landmarks = paths.far_apart(9)
    assert np.array_equal(extrapolate_by_paths(paths, paths, landmarks, landmarks), np.arange(300))


def test_landmarks_spread_to_other_numbers_of_the_same_nodes(paths):
    shuffle = np.random.default_rng(0).permutation(300)
    back = np.argsort(shuffle)
    lengths = paths.lengths[np.ix_(shuffle, shuffle)]
    other = MedialPaths(paths.nodes[shuffle], lengths, paths.radii[shuffle], back[paths.nearest])
    landmarks = paths.far_apart(9)
    assert np.array_equal(extrapolate_by_paths(paths, other, landmarks, back[landmarks]), back)


def test_landmarks_without_partner_do_not_count(paths):
    landmarks = paths.far_apart(9)
    partners = landmarks.copy()
    partners[[2, 5]] = NONE
    kept = partners != NONE
    expected = extrapolate_by_paths(paths, paths, landmarks[kept], landmarks[kept])
    assert np.array_equal(extrapolate_by_paths(paths, paths, landmarks, partners), expected)


@pytest.mark.uncompiled
def test_path_distortion_of_few_nodes():
    """Nodes at 0, 1, 3 on a line, mapped to 0, 1, 1.5: pairs change by 0, 1.5 and 1.5, or `CHANGED`."""
    place, image = np.array([0, 1.0, 3]), np.array([0, 1.0, 1.5])
    ids, ones = np.arange(3), np.ones(3)
    source, target = (MedialPaths(ids, np.abs(x[:, None] - x), ones, ids) for x in (place, image))
    changes = [0.0, min(1.5, CHANGED), min(1.5, CHANGED)]
    assert path_distortion(source, target, ids, ids) == pytest.approx(np.mean(changes))
    assert path_distortion(source, target, ids[:1], ids[:1]) == 0  # no pair


def slow_distinct_states(states, apart, least, most):
    kept = []
    for k, state in enumerate(states):
        if all(apart[state, states[e]].max() >= least for e in kept):
            kept.append(k)
    return kept[:most]


@pytest.mark.parametrize("seed", range(6))
def test_states_that_are_kept_differ_in_some_partner(seed):
    """One without counterpart (`NONE`, the last row) is as far from every partner as can be."""
    rng = np.random.default_rng(seed)
    places = rng.random((12, 2))
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    apart = np.pad(apart, ((0, 1), (0, 1)), constant_values=np.inf)
    apart[-1, -1] = 0
    states = rng.integers(NONE, 12, (200, 1 + seed % 3))
    for most in (3, 200):
        kept = distinct_states(states, apart, 0.4, most)
        assert kept.tolist() == slow_distinct_states(states, apart, 0.4, most)
    assert 3 < len(kept) < 200

import dataclasses

import numpy as np
import pytest

from datasets_gen.records import InputError
from medial import MatchConfig, Matching, extrapolate, match
from tests.medial.matching_shapes import diffusion_of, permuted, unequal_arms

QUICK = {"samples": 150, "times": 12, "restarts": 4}


@pytest.fixture(scope="module")
def shape():
    return unequal_arms()


def error(shape, order, matching, target):
    """Distance on the source between each point and the true origin of its image."""
    return np.linalg.norm(shape.points[order[matching.source_to_target]] - shape.points, axis=1)


def test_paper_matcher_recovers_a_shuffled_rotated_copy(shape):
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    order, target = permuted(shape, rotation=turn)
    found = match(shape, target, dataclasses.replace(MatchConfig.paper(), samples=300), seed=1)
    assert np.median(error(shape, order, found, target)) < 0.02
    assert found.restarts["chosen"].sum() == 1
    assert found.cost == pytest.approx(found.restarts["cost"].min())


def test_result_depends_on_the_seed_alone(shape, monkeypatch):
    _, target = permuted(shape)
    config = MatchConfig.from_dict(QUICK)
    first = match(shape, target, config, seed=3)
    monkeypatch.setattr("datasets_gen.compiled.thread_count", lambda: 1)
    second = match(shape, target, config, seed=3)
    assert np.array_equal(first.source_to_target, second.source_to_target)
    assert np.array_equal(first.confidence, second.confidence)
    for name, column in first.restarts.items():
        np.testing.assert_array_equal(column, second.restarts[name])


def test_extrapolation_from_true_landmarks(shape):
    order, target = permuted(shape)
    back = np.argsort(order)
    landmarks = np.array([[i, back[i]] for i in (10, 200, 400, 600)])
    found = extrapolate(shape, target, landmarks, MatchConfig.from_dict(QUICK))
    assert np.median(error(shape, order, found, target)) < 0.02
    assert np.array_equal(found.landmarks, landmarks)


def test_files_round_trip(shape, tmp_path):
    _, target = permuted(shape)
    saved = match(shape, target, MatchConfig.from_dict(QUICK), seed=5)
    saved.save(tmp_path / "map.npz")
    loaded = Matching.load(tmp_path / "map.npz")
    assert np.array_equal(saved.source_to_target, loaded.source_to_target)
    assert (saved.config, saved.seed, saved.flip) == (loaded.config, loaded.seed, loaded.flip)
    assert np.array_equal(saved.cost, loaded.cost, equal_nan=True)  # NaN: found by path length
    assert set(saved.restarts) == set(loaded.restarts)
    assert loaded.restarts["chosen"].dtype == bool


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"sample": 3}, "unknown match setting 'sample'"),
        ({"samples": 0}, "samples must be an integer of at least 1, got 0"),
        ({"candidates": 1.5}, r"candidates must lie in \(0, 1\], got 1.5"),
    ],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(InputError, match=message):
        MatchConfig.from_dict(settings)


def test_operators_cannot_be_mixed(shape):
    with pytest.raises(InputError, match="'robust' diffusion to a 'heat' one"):
        match(shape, dataclasses.replace(shape, operator="heat"))


def test_landmarks_must_exist(shape):
    with pytest.raises(InputError, match="target point ids"):
        extrapolate(shape, shape, np.array([[0, len(shape)]]))
    with pytest.raises(InputError, match="source point ids"):
        extrapolate(shape, shape, np.zeros((0, 2), dtype=int))


def test_a_cloud_smaller_than_the_samples(shape):
    few = np.random.default_rng(0).choice(len(shape), 90, replace=False)
    small = diffusion_of(shape.points[few], shape.normals[few], modes=20)
    found = match(small, shape)
    assert len(found) == 90

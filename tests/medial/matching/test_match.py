import dataclasses

import numpy as np
import pytest

from datasets_gen.records import InputError
from medial import Departures, MatchConfig, extrapolate, match
from medial.matching.common_units import check_comparable
from medial.matching.landmarks.candidates import diffusion_sets
from medial.matching.prepared import prepare_pair
from medial.operator import Operator
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


def test_departures_are_read_by_name():
    config = MatchConfig.from_dict({"departures": "none"})
    assert config.departures == Departures.none()
    assert MatchConfig.from_dict(dataclasses.asdict(config)) == config


def test_the_papers_landmarks_are_the_partners_that_equation_16_found(shape):
    _, target = permuted(shape)
    config = dataclasses.replace(MatchConfig.paper(), samples=150, restarts=3)
    found = match(shape, target, config, seed=1)
    chosen = found.restarts["chosen"]
    assert found.landmarks[0, 0] == found.restarts["first"][chosen][0]
    assert found.landmarks[0, 1] == found.restarts["partner"][chosen][0]
    pair = prepare_pair(shape, target, config, 1)
    start = int(np.flatnonzero(pair.source.descriptors.samples == found.landmarks[0, 0])[0])
    sets = diffusion_sets(pair.source.descriptors, pair.target.descriptors, pair.times, config, [start])
    assert np.array_equal(found.landmarks, sets[0])


def test_only_a_deformation_checks_the_mirror_image(shape):
    _, target = permuted(shape)
    config = dataclasses.replace(MatchConfig.paper(), samples=150, restarts=3)
    assert match(shape, target, config).mirror_check == "unchecked"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"sample": 3}, "unknown match setting 'sample'; did you mean 'samples'"),
        ({"samples": 1}, "match setting samples is 1; give a whole number of at least 2"),
        ({"restarts": 10**9}, "match setting restarts is 1000000000; give a whole number of at most 100000"),
        ({"samples": 2.5}, "match setting samples must be a whole number, got 2.5"),
        ({"both_ways": "false"}, "match setting both_ways must be true or false, got 'false'"),
        ({"starts": "spred"}, "match setting starts must be one of 'random', 'spread', got 'spred'"),
        ({"candidates": "x"}, "match setting candidates must be a finite number, got 'x'"),
        ({"departures": {"nonsense": True}}, "unknown departure 'nonsense'"),
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
    found = match(small, shape, MatchConfig.from_dict(QUICK))
    assert len(found) == 90


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"eta": None}, "built with eta=0.5 and eta=None; use one eta"),
        ({"sigma_e": 4.0}, "sigma_e=5.0 and sigma_e=4.0"),
        ({"reference_points": 900.0}, "reference_points"),
        ({"departures": {"radius_cap": False}}, "different departures"),
    ],
)
def test_settings_of_operators_cannot_be_mixed(shape, changed, message):
    for call in (check_comparable, match):
        with pytest.raises(InputError, match=message):
            call(*built_with(shape, changed))


def test_operators_may_differ_in_what_changes_no_result(shape):
    quick = {"samples": 40, "times": 6, "restarts": 1}
    one, other = built_with(shape, {"tolerance": 0.1, "device": "llvm", "modes": 9})
    found, same = (match(one, each, MatchConfig.from_dict(quick)) for each in (other, one))
    assert np.array_equal(found.source_to_target, same.source_to_target)


def built_with(shape, changed):
    """The shape as if it were built with the default settings, and with some that are changed."""
    made = dataclasses.asdict(Operator())
    return [dataclasses.replace(shape, operator="medial", parameters=each) for each in (made, made | changed)]


def test_seeds_are_whole_numbers(shape):
    for seed in (-1, 1.5, "x", None):
        with pytest.raises(InputError, match="seed is"):
            match(shape, shape, seed=seed)

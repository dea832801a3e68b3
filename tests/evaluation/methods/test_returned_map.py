import numpy as np
import pytest

from datasets_gen import InputError
from evaluation.methods import dense
from evaluation.methods.returned_map import checked_map
from medial import Matching
from medial.matching.result import Alternative

N, M = 6, 4


def made(**changes):
    fields = {
        "source_to_target": np.array([0, 1, 2, 3, -1, 0]),
        "landmarks": np.array([[0, 0], [5, 3]]),
        "cost": 0.5,
        "confidence": np.full(N, 0.5),
        "restarts": {"cost": np.ones(2)},
    }
    return Matching(**{**fields, **changes})


def other(**changes):
    fields = {"probability": 0.2, "source_to_target": np.zeros(N, int), "confidence": np.zeros(N)}
    return (Alternative(**{**fields, **changes}),)


def test_a_map_that_keeps_the_promises_passes_and_can_be_stored(tmp_path):
    given = made(
        source_to_target=np.array([0, 1, 2, 3, -1, 0], np.int16),
        confidence=np.full(N, 0.5, np.float32),
        cost=np.float32(0.5),
        alternatives=list(other()),
        about={"weights": np.ones(2)},
    )
    found = checked_map(given, N, M)
    found.save(tmp_path / "map.npz")
    loaded = Matching.load(tmp_path / "map.npz")
    assert loaded.source_to_target.dtype == np.int64
    assert loaded.confidence.dtype == np.float64
    assert loaded.source_to_target.tolist() == [0, 1, 2, 3, -1, 0]
    assert len(loaded.alternatives) == 1
    assert np.isnan(checked_map(made(cost=float("nan")), N, M).cost)  # of methods without one


WRONG = {
    "source_to_target has shape": {"source_to_target": np.zeros(N + 1, int)},
    "not in .-1, 4.; -1 is no match": {"source_to_target": np.full(N, M)},
    "target ids -2 to -2": {"source_to_target": np.full(N, -2)},
    "type float64, not integer": {"source_to_target": np.zeros(N)},
    "type bool, not integer": {"source_to_target": np.zeros(N, bool)},
    "source_to_target is a list, not a NumPy array": {"source_to_target": [0] * N},
    "masked array": {"source_to_target": np.ma.masked_array(np.zeros(N, int), np.ones(N, bool))},
    "confidence has shape": {"confidence": np.ones((N, 1))},
    "confidence holds nan at point 2 .1 of 6": {"confidence": np.array([1, 1, np.nan, 1, 1, 1])},
    "confidence holds 1.5 at point 0": {"confidence": np.full(N, 1.5)},
    "confidence holds -0.1": {"confidence": np.full(N, -0.1)},
    "confidence is of type complex128": {"confidence": np.ones(N, complex)},
    "landmarks has shape .2, 3.": {"landmarks": np.zeros((2, 3), int)},
    "landmarks is nothing": {"landmarks": None},
    "landmarks hold source ids 6": {"landmarks": np.array([[6, 0]])},
    "landmarks hold target ids -1": {"landmarks": np.array([[0, -1]])},
    "landmarks is of type float64": {"landmarks": np.zeros((1, 2))},
    "cost is a str": {"cost": "low"},
    "cost is inf": {"cost": float("inf")},
    "seed is a float": {"seed": 0.5},
    "mirror_check is 'maybe'": {"mirror_check": "maybe"},
    "config is a dict": {"config": {}},
    "restarts are a list": {"restarts": []},
    "restarts.'a'. is of type object": {"restarts": {"a": np.array([None])}},
    "restarts has a column 'a.x00b'": {"restarts": {"a\0b": np.ones(2)}},
    "restarts has a column 'xxx": {"restarts": {100 * "x": np.ones(2)}},
    "restarts has a column 7": {"restarts": {7: np.ones(2)}},
    "restarts.'a'. is no array of numbers": {"restarts": {"a": [[1], [1, 2]]}},
    "probability is 5, not in": {"probability": 5.0},
    "probability is -1, not in": {"probability": -1},
    "cost is an int, not a number that can be stored": {"cost": 10**400},
    "about cannot be stored": {"about": {"x": object()}},
    "source_points has shape": {"source_points": np.zeros((N, 2))},
    "alternatives are nothing": {"alternatives": None},
    "alternatives are a tuple": {"alternatives": (1,)},
    "alternative 0: source_to_target has shape": {"alternatives": other(source_to_target=np.zeros(2, int))},
    "alternative 0: source_to_target holds target ids": {
        "alternatives": other(source_to_target=np.full(N, M))
    },
    "alternative 0: confidence has shape": {"alternatives": other(confidence=np.zeros(1))},
    "alternative 0: probability holds 2": {"alternatives": other(probability=2.0)},
}


@pytest.mark.parametrize("said", WRONG)
def test_what_breaks_a_promise_is_named(said):
    with pytest.raises(InputError, match=said) as caught:
        checked_map(made(**WRONG[said]), N, M)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("found", [None, np.zeros(N, int), (np.zeros(N, int), np.ones(N)), "map"])
def test_only_a_matching_is_a_map(found):
    with pytest.raises(InputError, match="not a Matching; return dense"):
        checked_map(found, N, M)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ((np.ma.array(np.zeros(N, int), mask=np.ones(N)), np.ones(N)), "target ids are a masked array; fill"),
        ((np.zeros(N, int), np.ma.array(np.ones(N), mask=np.ones(N))), "confidences are a masked array"),
        ((5, 5), "target ids of shape .. with confidences of shape"),
        ((np.zeros((N, 2), int), np.ones(N)), "target ids of shape .6, 2."),
        ((np.zeros(N, int), "abcde"), "confidences are of type <U5, not numbers"),
        ((np.zeros(N, int), np.ones(N - 1)), "with confidences of shape .5,."),
        (([[1], [1, 2]], np.ones(2)), "target ids are a list, no array"),
    ],
    ids=["mask", "mask of confidence", "numbers", "table", "text", "lengths", "ragged"],
)
def test_dense_refuses_what_is_no_map(given, said):
    with pytest.raises(InputError, match=said):
        dense(*given)


def test_dense_does_not_round():
    with pytest.raises(InputError, match="target ids are of type float64"):
        dense(np.full(N, 1.7), np.ones(N))
    with pytest.raises(InputError, match="landmarks are of type float64"):
        dense(np.zeros(N, int), np.ones(N), landmarks=np.full((1, 2), 0.5))


def test_the_checked_map_is_not_the_method_s_own_memory():
    mine = np.zeros(N, int)
    found = checked_map(made(source_to_target=mine), N, M)
    mine[:] = 3
    assert found.source_to_target.tolist() == [0] * N

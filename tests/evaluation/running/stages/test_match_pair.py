"""A method has its inputs to itself."""

import ctypes

import numpy as np
import pytest

from evaluation.methods import METHODS
from evaluation.running.read_only import read_only
from evaluation.running.stages import match_pair
from evaluation.running.stages.interface import Inputs
from medial import Diffusion
from scanner_sim import sample
from tests.evaluation.meshes import blob

BODY = blob(3)


@pytest.fixture
def inputs():
    clouds = {f"{side}_scan": sample(BODY, 80, seed) for seed, side in enumerate(("source", "target"))}
    built = {
        f"{side}_heat": Diffusion.from_points(cloud.points, cloud.normals, "heat", 10)
        for side, cloud in zip(("source", "target"), clouds.values(), strict=True)
    }
    stored = read_only(clouds | built)
    return Inputs({role: role for role in stored}, stored.__getitem__, {}.get, lambda *_: None)


def spec(method_file, trouble):
    return {"method": f"{method_file}:Nearest", "options": {"trouble": trouble}, "seed": 0}


def matched(inputs, method_file, trouble=""):
    found = match_pair.compute(spec(method_file, trouble), inputs)
    return found.save.__self__.source_to_target


def test_a_method_that_writes_past_the_locks_spoils_its_own_copy_alone(inputs, method_file):
    before = matched(inputs, method_file)
    kept = {role: inputs.load(role).points.copy() for role in inputs.keys}
    assert (matched(inputs, method_file, "base") != before).any()  # it has seen its own zeros
    for role, points in kept.items():
        assert np.array_equal(inputs.load(role).points, points)
    assert np.array_equal(matched(inputs, method_file), before)


def test_every_array_of_an_operator_is_a_copy(inputs, monkeypatch):
    """Memory that is written by address, as code in other languages does."""
    given = []

    class Spy:
        operators = ("heat",)
        uses_truth = False

        def match(self, source, target, seed):
            given.extend((source, target))
            raise KeyError

    monkeypatch.setattr(match_pair, "create", lambda *_: Spy())
    with pytest.raises(KeyError):
        match_pair.compute({"method": next(iter(METHODS)), "options": {}, "seed": 0}, inputs)
    for side, cloud in zip(("source", "target"), given, strict=True):
        stored, own = inputs.load(f"{side}_heat"), cloud.operators["heat"]
        arrays = {name: each for name, each in vars(own).items() if isinstance(each, np.ndarray)}
        assert {"points", "normals", "areas", "centers"} <= set(arrays)
        for name, array in arrays.items():
            assert not np.shares_memory(array, getattr(stored, name)), name
            assert np.array_equal(array, getattr(stored, name)), name
            before = getattr(stored, name).copy()
            ctypes.memset(array.ctypes.data, 0, array.nbytes)
            assert np.array_equal(getattr(stored, name), before), name

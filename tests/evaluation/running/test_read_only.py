from dataclasses import dataclass, fields, is_dataclass, replace

import numpy as np
import pytest
from scipy.sparse import csr_array

from evaluation.methods import MethodInput
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.running.read_only import read_only
from medial import Diffusion
from scanner_sim import sample
from tests.evaluation.meshes import blob

BODY = blob(3)


def arrays(value):
    """Every array within a value."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, dict):
        for each in value.values():
            yield from arrays(each)
    elif is_dataclass(value):
        for each in fields(value):
            yield from arrays(getattr(value, each.name))


def given():
    scan = sample(BODY, 200, seed=1)
    built = {name: Diffusion.from_points(scan.points, scan.normals, name, 20) for name in ("medial", "heat")}
    return MethodInput("a", scan, built, BODY.at(scan.face_ids, scan.barycentrics))


def test_nothing_that_a_method_gets_can_be_written_into():
    whole = given()
    locked = read_only(whole)
    found = list(arrays(locked))
    assert len(found) == len(list(arrays(whole))) > 20
    for each in found:
        with pytest.raises(ValueError, match="read-only"):
            each[...] = 0
        with pytest.raises(ValueError, match="WRITEABLE"):
            each.setflags(write=True)


def test_the_value_itself_is_locked_too_and_nothing_is_copied():
    whole = given()
    locked = read_only(whole)
    assert np.shares_memory(whole.points, locked.points)
    with pytest.raises(ValueError, match="read-only"):
        whole.points[0] = 0


def test_entries_of_dictionaries_stay_with_whoever_made_them():
    whole = read_only(given())
    one, other = read_only(whole), read_only(whole)
    one.operators["medial"].parameters["eta"] = "changed"
    one.operators.clear()
    assert "changed" not in other.operators["medial"].parameters.values()
    assert set(other.operators) == {"medial", "heat"}


def test_views_lists_and_sparse_matrices():
    base = np.zeros(9)
    locked = read_only([base[::2], (csr_array(np.eye(3)),)])
    with pytest.raises(ValueError, match="read-only"):
        base[0] = 1
    with pytest.raises(ValueError, match="read-only"):
        locked[1][0].data[0] = 1


def test_records_keep_what_they_have_computed():
    @dataclass
    class Record:
        points: np.ndarray

    record = Record(np.zeros(3))
    record.tree = np.ones(3)
    assert read_only(record).tree.tolist() == [1, 1, 1]
    assert not read_only(record).tree.flags.writeable


def test_distances_work_on_read_only_arrays():
    free, locked = SurfaceDistance(BODY), read_only(SurfaceDistance(read_only(BODY)))
    scan = read_only(sample(BODY, 60, seed=0))
    half = [scan.face_ids[:30], scan.barycentrics[:30], scan.face_ids[30:], scan.barycentrics[30:]]
    assert np.array_equal(free(*half), locked(*half))
    assert np.array_equal(free.to_nearest(*half), locked.to_nearest(*half))
    assert np.array_equal(free.from_vertices(np.array([3])), locked.from_vertices(np.array([3])))
    with pytest.raises(ValueError, match="read-only"):
        locked.graph.data[0] = 1


def test_a_locked_record_can_be_changed_by_copying():
    locked = read_only(given()).scan
    assert replace(locked, points=locked.points + 1).points.flags.writeable

import pytest

from datasets_gen import InputError
from evaluation.running.cluster import _compare_versions
from evaluation.running.environment import usable_processors, versions

HERE = {"numpy": "2.0", "scipy": "1.14"}


def test_workers_with_the_same_versions_are_taken():
    _compare_versions(HERE, {"tcp://a": {**HERE, "other": "1"}, "tcp://b": dict(HERE)})


@pytest.mark.parametrize(
    ("there", "message"),
    [
        ({**HERE, "scipy": "1.15"}, "worker tcp://b has scipy 1.15, this process has 1.14"),
        ({"numpy": "2.0"}, "worker tcp://b has scipy missing, this process has 1.14"),
        (ModuleNotFoundError("No module named 'evaluation'"), "worker tcp://b cannot use medialbench"),
    ],
)
def test_workers_with_other_versions_are_named(there, message):
    with pytest.raises(InputError, match=message) as error:
        _compare_versions(HERE, {"tcp://a": HERE, "tcp://b": there})
    assert "\n" not in str(error.value)


def test_versions_hold_what_results_are_computed_with():
    assert {"python", "numpy", "scipy", "numba", "mitsuba", "drjit", "trimesh"} <= set(versions())


def test_processors_are_counted_where_affinity_is_not_known(monkeypatch):
    monkeypatch.delattr("os.sched_getaffinity", raising=False)
    assert usable_processors() >= 1

"""A configuration of seconds, and a cluster that all tests of a file share."""

import pytest

from evaluation.generation import GenerationConfig


@pytest.fixture
def tiny(blobs):
    """Makes a configuration of seconds; keyword arguments replace sections."""

    def make(**changes):
        table = {
            "name": "tiny",
            "dataset": [{"name": str(blobs)}],
            "scan": {"points": 120, "views": 3, "scanner": {"resolution": [60, 60], "stripes": 120}},
            "draw": {"threshold": [0.2, 0.7], "per_render": 2},
        }
        return GenerationConfig.from_table({**table, **changes})

    return make


@pytest.fixture(scope="module")
def scheduler():
    """Address of a cluster of one worker: to start one takes longer than what is made."""
    from distributed import LocalCluster

    settings = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": "127.0.0.1:0"}
    with LocalCluster(host="127.0.0.1", **settings) as cluster:
        yield cluster.scheduler_address

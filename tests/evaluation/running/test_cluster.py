import os
import sys
from importlib import import_module

import pytest

from datasets_gen import InputError
from evaluation.running.cluster import _compare_versions, connect
from evaluation.running.environment import usable_processors, versions
from evaluation.running.tls import security_of

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
    for told, expected in ((6, 6), (None, 1)):
        monkeypatch.setattr("os.cpu_count", lambda told=told: told)
        assert usable_processors() == expected


def listening(pid):
    """Addresses at which a process listens."""
    psutil = pytest.importorskip("psutil")
    every = psutil.Process(pid).net_connections("inet")
    return {each.laddr.ip for each in every if each.status == psutil.CONN_LISTEN}


@pytest.fixture(scope="module")
def local(tmp_path_factory):
    with connect(tmp_path_factory.mktemp("results"), 2, None) as cluster:
        yield cluster


def test_files_beside_an_experiment_hide_no_library_from_workers(local):
    assert set(local.client.run(lambda: sys.flags.safe_path).values()) == {True}


def test_the_environment_is_as_before(tmp_path, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    before = dict(os.environ)
    with connect(tmp_path, 1, None):
        pass
    assert dict(os.environ) == before


def test_a_local_cluster_listens_on_loopback_alone(local):
    psutil = pytest.importorskip("psutil")
    workers = list(local.client.run(os.getpid).values())
    mine = psutil.Process()
    started = {child.pid for child in mine.children(recursive=True)}
    assert set(workers) <= started
    for pid in (mine.pid, *started):
        assert listening(pid) <= {"127.0.0.1"}
    assert listening(mine.pid)
    assert all(listening(pid) for pid in workers)


def test_who_has_no_certificate_cannot_talk_to_a_local_cluster(local):
    from evaluation.running.scheduler_check import check_scheduler
    from evaluation.running.tls import certificate_of_this_run

    workers = list(local.client.scheduler_info()["workers"])
    addresses = [local.client.scheduler.address, *workers]
    assert all(address.startswith("tls://127.0.0.1:") for address in addresses)
    for address in addresses:
        plain = address.replace("tls://", "tcp://")
        with pytest.raises(InputError, match="no Dask scheduler answers"):
            check_scheduler(plain, security_of(plain, None), versions())
        with pytest.raises(InputError, match="no Dask scheduler answers"):
            check_scheduler(address, certificate_of_this_run(), versions())
    assert local.client.submit(sum, [1, 2]).result() == 3


@pytest.mark.parametrize("page", ["", "status", "info/main/workers.html", "metrics", "json/counts.json"])
def test_no_page_is_served_unless_asked_for(local, page):
    from urllib.error import HTTPError
    from urllib.request import urlopen

    port = local.client.cluster.scheduler.http_server.port
    with pytest.raises(HTTPError, match="404"):
        urlopen(f"http://127.0.0.1:{port}/{page}", timeout=5)
    assert local.dashboard == ""


def test_settings_of_dask_are_as_before(local, tmp_path):
    import dask

    import_module("distributed")
    before = dask.config.get("distributed")
    with connect(tmp_path, 1, None, dashboard=True) as cluster:
        assert cluster.dashboard
        assert listening(os.getpid()) <= {"127.0.0.1"}
    assert dask.config.get("distributed") == before

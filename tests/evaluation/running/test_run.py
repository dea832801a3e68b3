import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from datasets_gen import InputError
from evaluation import ResultsStore, preview, run
from evaluation.results.folder_lock import lock_folder
from evaluation.results.store import TIMING

ROOT = Path(__file__).resolve().parents[3]


def content(store):
    """The table without what differs from run to run."""
    return store.table().drop(columns=list(TIMING))


class Counter:
    """Progress that counts."""

    def __init__(self):
        self.planned, self.reports, self.stored, self.begun = {}, [], 0, 0

    def begin(self, waiting, stored, workers, dashboard):
        self.planned, self.stored, self.begun = waiting, stored, self.begun + 1

    def advance(self, report):
        self.reports.append(report)

    def end(self):
        pass


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A finished run, shared: experiment, store, what progress was told."""
    made = {}

    def get(small):
        if not made:
            experiment, counter = small(), Counter()
            store = run(experiment, tmp_path_factory.mktemp("run") / "results", jobs=1, progress=counter)
            made.update(experiment=experiment, store=store, counter=counter)
        return made

    return get


def test_a_run_ends_in_a_table(small, finished):
    store = finished(small)["store"]
    assert store.failures().empty
    table = store.table()
    eq18 = table[table.kind == "stability"]
    assert len(eq18) == 1 + 3 * 2  # the reference itself, then poses x thresholds
    itself = eq18[eq18.regime == "reference"]
    assert itself.eq18.tolist() == [0]
    assert itself.source_missing.tolist() == [0]
    scans = eq18[eq18.regime != "reference"]
    low, high = (scans[scans.source_threshold == t] for t in (0.2, 0.7))
    assert high.source_missing.mean() > low.source_missing.mean()
    maps = table[table.kind == "matching"]
    assert maps[["source_pose", "target_pose"]].to_numpy().tolist() == [["rest", "bent"], ["rest", "curled"]]
    assert (maps.geodesic_symmetric_mean <= maps.geodesic_mean).all()
    assert maps.excess_mean.ge(0).all()
    assert (
        maps.excess_mean - (maps.geodesic_mean - maps.oracle_mean)
    ).abs().max() < 1e-9  # no point is left out
    assert (maps.medial_path_mean >= maps.medial_mean).all()
    assert (maps.gross == (maps.geodesic_mean > 15)).all()
    assert (table[table.regime != "reference"].n_points == 300).all()


def evaluated(store, row):
    """True and found places on the rest pose of the points at which a map was measured."""
    rest = store.collection(row.dataset).reference
    source, target = store.scan(row.source_scan), store.scan(row.target_scan)
    here, there = (rest.at(each.face_ids, each.barycentrics) for each in (source, target))
    spec = store.record("score", row.score_key)["spec"]
    assert spec["evaluated"] == 100
    picked = np.random.default_rng(spec["seed"]).choice(len(source), 100, replace=False)
    return rest, here[picked], there[store.matching(row.map_key).source_to_target[picked]], there


def around_edges(rest, here, there):
    """Lengths of paths along edges of a mesh between places, with straight ends: no geodesic is longer."""
    edges = np.unique(np.sort(rest.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0)
    lengths = np.linalg.norm(rest.vertices[edges[:, 0]] - rest.vertices[edges[:, 1]], axis=1)
    graph = csr_array((lengths, tuple(edges.T)), shape=(len(rest.vertices),) * 2)
    ends = [cKDTree(rest.vertices).query(each) for each in (here, there)]
    along = dijkstra(graph, directed=False, indices=ends[0][1])[np.arange(len(here)), ends[1][1]]
    return ends[0][0] + along + ends[1][0]


def test_errors_of_maps_lie_between_straight_lines_and_ways_along_edges(small, finished):
    """In 100 / sqrt(area) of the rest pose."""
    store = finished(small)["store"]
    for _, row in store.table().query("kind == 'matching'").iterrows():
        rest, here, found, every = evaluated(store, row)
        unit = 100 / np.sqrt(rest.area)
        straight = unit * np.linalg.norm(found - here, axis=1)
        assert straight.mean() > 1
        assert straight.mean() <= row.geodesic_mean <= unit * around_edges(rest, here, found).mean()
        assert row.geodesic_mean == pytest.approx(straight.mean(), rel=0.15)
        assert row.geodesic_median == pytest.approx(np.median(straight), rel=0.2)
        least = unit * cKDTree(every).query(here)[0]
        assert row.oracle_mean == pytest.approx(least.mean(), rel=0.1)


def test_eq18_is_the_difference_of_dimensionless_kernels(small, finished):
    """Of all pairs, with the nearest sample of the rest pose for f(x); a norm over n pairs divided by n."""
    store = finished(small)["store"]
    rows = store.table().query("kind == 'stability'")
    reference = store.operator(rows[rows.regime == "reference"].source_operator.item())
    rest = store.collection(rows.dataset.iloc[0]).reference
    for _, row in rows[rows.regime != "reference"].iterrows():
        scan, cloud = store.scan(row.source_scan), store.operator(row.source_operator)
        same = cKDTree(reference.points).query(rest.at(scan.face_ids, scan.barycentrics))[1]
        every, differences = np.arange(len(scan)), []
        for t in store.score(row.score_key)["times"]:
            gap = cloud.kernel(t, every, every) - reference.kernel(t, same, same)
            differences.append(rest.area * np.sqrt((gap**2).mean()))
        assert row.eq18 == pytest.approx(np.mean(differences) / np.sqrt(500), rel=0.35)


def test_the_store_stands_by_itself(small, finished):
    store = ResultsStore(finished(small)["store"].folder)
    row = store.table().query("kind == 'matching'").iloc[0]
    collection = store.collection(row.dataset)
    scan, found = store.scan(row.source_scan), store.matching(row.map_key)
    assert [shape.pose for shape in collection.shapes] == ["bent", "curled", "rest"]
    assert len(found) == len(scan) == row.n_points
    assert len(store.score(row.score_key)["curve"]) == 51
    eq18 = store.table().query("kind == 'stability'").iloc[-1]
    assert len(store.operator(eq18.source_operator)) == eq18.n_points
    info = store.run_info()
    assert {"numpy", "scipy", "numba", "mitsuba", "drjit", "trimesh", "python"} <= set(info["versions"])
    assert set(info["mitsuba_variants"]) <= {"scalar_rgb", "llvm_ad_rgb", "cuda_ad_rgb"}
    assert len(info["mitsuba_variants"]) == 1
    assert info["rows"] == info["rows_planned"] == len(store.table())
    with pytest.raises(InputError, match="no data set 'cat'"):
        store.collection("cat")


def test_nothing_is_run_twice_and_nothing_started(small, finished):
    made, counter = finished(small), Counter()
    assert preview(made["experiment"], made["store"].folder).waiting == {}
    before = made["store"].table()
    again = run(made["experiment"], made["store"].folder, scheduler="tcp://nowhere:1", progress=counter)
    assert counter.reports == []
    pd.testing.assert_frame_equal(again.table(), before)


def test_more_of_the_same_runs_only_what_is_new(small, finished):
    made = finished(small)
    sweep = {"threshold": [0.2, 0.7, 0.8]}
    more = small(stability={"operators": ["heat"], "sweep": sweep, "pairs": 500})
    waiting = preview(more, made["store"].folder).waiting
    assert waiting == {"scan": 3, "operator": 3, "score": 3}  # no render, no map


def test_a_result_cut_short_is_made_again(small, finished):
    made = finished(small)
    store = made["store"]
    row = store.table().query("kind == 'matching'").iloc[0]
    path = store.path("map", row.map_key)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    assert preview(made["experiment"], store.folder).waiting == {"map": 1}
    note = store.path("score", row.score_key)
    text = note.read_text()
    note.write_text(text[:50])
    assert preview(made["experiment"], store.folder).waiting == {"map": 1, "score": 1}
    path.write_bytes(whole)
    note.write_text(text)
    assert preview(made["experiment"], store.folder).waiting == {}


def test_preview_of_an_empty_folder(small, tmp_path):
    found = preview(small(), tmp_path / "none", jobs=3)
    assert found.waiting == {"shape": 1, "scan": 7, "operator": 8, "render": 3, "score": 9, "map": 2}
    assert (found.rows, found.stored, found.workers) == (9, 0, 3)
    assert found.poses == {"blob": ("rest", "bent", "curled")}
    typical = 15.0 + 7 * 0.2 + 8 * 1.1 * 300 / 5000 + 3 * 1.0 + 9 * 0.5 + 2 * 10.0
    assert found.seconds == pytest.approx(typical / 3)  # 3 workers; operators typically have 5,000 points
    assert not (tmp_path / "none").exists()


def test_preview_counts_what_the_run_then_does(small, finished, tmp_path):
    made = finished(small)
    before = preview(made["experiment"], tmp_path / "none").waiting
    assert made["counter"].planned == before
    assert made["counter"].begun == 1
    assert len(made["counter"].reports) == sum(before.values())
    after = preview(made["experiment"], made["store"].folder)
    assert (after.waiting, after.seconds) == ({}, 0)
    assert after.stored == sum(before.values())


def test_preview_names_data_sets_that_cannot_be_used(small, tmp_path):
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="holds no mesh files"):
        preview(small(dataset=[{"name": str(tmp_path / "empty")}]), tmp_path / "none")
    with pytest.raises(InputError, match="seed of 'human' is -1"):
        preview(small(dataset=[{"name": "human", "options": {"seed": -1}}]), tmp_path / "none")


def test_two_runs_cannot_share_a_folder(small, finished):
    made = finished(small)
    with (
        lock_folder(made["store"].folder),
        pytest.raises(InputError, match=f"in use by process {os.getpid()}") as error,
    ):
        run(made["experiment"], made["store"].folder)
    assert "\n" not in str(error.value)


def test_a_folder_of_another_version(small, tmp_path):
    (tmp_path / "run.json").write_text(json.dumps({"format": 0}))
    with pytest.raises(InputError, match="format 0"):
        run(small(), tmp_path)


def test_a_table_of_the_previous_format_is_read(small, finished, tmp_path):
    table = finished(small)["store"].table()
    old = table.rename(columns={"mirror_check": "flip_decision"})
    old["flip_decision"] = pd.Series(
        ["kept", "flipped", "undecided", *[None] * (len(old) - 3)], dtype="string"
    )
    old.to_parquet(tmp_path / "table.parquet")
    (tmp_path / "run.json").write_text(json.dumps({"format": 1}))
    found = ResultsStore(tmp_path).table()
    assert found.columns.tolist() == table.columns.tolist()
    assert found.mirror_check.tolist()[:3] == ["agrees", "overruled", "undecided"]
    assert found.mirror_check[3:].isna().all()


def test_a_folder_that_cannot_be_written(small, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        run(small(), tmp_path / "file" / "results")


def test_a_scheduler_that_is_not_there(small, tmp_path):
    with pytest.raises(InputError, match="no Dask scheduler answers"):
        run(small(), tmp_path / "results", scheduler="tcp://127.0.0.1:1")
    assert [path.name for path in (tmp_path / "results").iterdir()] == [".lock"]


def test_unknown_poses_and_methods_are_named(small, tmp_path, blobs):
    with pytest.raises(InputError, match="unknown method 'medal'; did you mean 'medial'"):
        preview(small(method=[{"name": "medal"}]), tmp_path)
    with pytest.raises(InputError, match=r"unknown data set .* 'humn'; did you mean 'human'"):
        run(small(dataset=[{"name": "humn"}]), tmp_path / "none")
    assert not (tmp_path / "none").exists()


TROUBLE = {
    "raise": ("error", "RuntimeError: out of luck"),
    "wrong": ("error", "target ids"),
    "hang": ("timeout", "no result after 10 s"),
    "die": ("crash", "took its worker down 2 times"),
}


@pytest.mark.slow
def test_methods_that_fail_do_not_stop_the_sweep(small, tmp_path, method_file):
    common = {"stability": None, "matching": {"pairs": [["rest", "bent"]]}}
    methods = [
        {"name": f"{method_file}:Nearest", "label": trouble or "fine", "trouble": trouble}
        for trouble in (*TROUBLE, "")
    ]
    run(small(method=methods[-1:], **common), tmp_path / "results", jobs=2)  # compiles, without a hurry
    counter = Counter()
    experiment = small(method=methods, timeout=10.0, **common)
    store = run(experiment, tmp_path / "results", jobs=2, progress=counter)
    assert store.table().method.tolist() == ["fine"]
    failures = store.failures()
    for trouble, (kind, reason) in TROUBLE.items():
        found = failures[failures.label == f"blob rest to bent {trouble}"]
        assert found.kind.tolist() == [kind]
        assert reason in found.reason.iloc[0]
        follower = failures[failures.label == f"blob rest to bent {trouble} error"]
        assert follower.kind.tolist() == ["blocked"]
        assert "not run because of" in follower.reason.iloc[0]
    assert len(failures) == 2 * len(TROUBLE)
    assert len({report.task.key for report in counter.reports}) == len(counter.reports)


SCRIPT = """
import sys
from evaluation import run
if __name__ == "__main__":
    run(sys.argv[1], sys.argv[2], jobs=int(sys.argv[3]))
"""


def launch(tmp_path, experiment, folder, jobs):
    script, settings = tmp_path / "go.py", tmp_path / "experiment.toml"
    script.write_text(SCRIPT)
    settings.write_text(experiment.to_toml())
    command = [sys.executable, str(script), str(settings), str(folder), str(jobs)]
    return subprocess.Popen(
        command, env={**os.environ, "PYTHONPATH": str(ROOT)}, stderr=subprocess.PIPE, start_new_session=True
    )


@pytest.mark.long
@pytest.mark.slow
def test_killed_runs_go_on_to_the_same_table(small, finished, tmp_path):
    made, folder = finished(small), tmp_path / "killed"
    for signal_sent, results in ((signal.SIGKILL, 4), (signal.SIGINT, 9), (signal.SIGKILL, 14)):
        process = launch(tmp_path, made["experiment"], folder, 2)
        deadline = time.monotonic() + 120
        while len(list(folder.glob("*/*.json"))) < results and process.poll() is None:
            assert time.monotonic() < deadline
            time.sleep(0.02)
        os.kill(process.pid, signal_sent)
        process.wait(timeout=60)
    store = run(made["experiment"], folder, jobs=2)
    assert store.failures().empty
    pd.testing.assert_frame_equal(content(store), content(made["store"]))


@pytest.mark.slow
def test_a_running_cluster_gives_the_same_table(small, finished, tmp_path):
    from distributed import LocalCluster

    made = finished(small)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        store = run(made["experiment"], tmp_path / "results", scheduler=cluster.scheduler_address)
    pd.testing.assert_frame_equal(content(store), content(made["store"]))


def test_missing_packages_are_named(small, tmp_path):
    lacking = tmp_path / "lacking.py"
    lacking.write_text(
        "from dataclasses import dataclass\n"
        "from evaluation.methods import Method\n"
        "@dataclass(frozen=True, kw_only=True)\n"
        "class Lacking(Method):\n"
        "    requires = {'no_such_package': 'no-such-package'}\n"
    )
    found = preview(small(method=[{"name": f"{lacking}:Lacking", "label": "lacking"}]), tmp_path)
    assert "pip install no-such-package" in found.unavailable["lacking"]


@pytest.mark.slow
def test_ctrl_c_is_not_heard_by_the_workers(small, tmp_path, method_file):
    """A terminal sends it to all processes; the run ends its workers itself, and they say nothing."""
    hangs = {"name": f"{method_file}:Nearest", "label": "hang", "trouble": "hang"}
    folder = tmp_path / "results"
    process = launch(tmp_path, small(stability=None, method=[hangs]), folder, 2)
    deadline = time.monotonic() + 120
    while not list(folder.glob("running/*hang*.json")) and process.poll() is None:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)
    said = process.communicate(timeout=60)[1].decode()
    assert said.count("Traceback") <= 1, said  # that of the script itself
    assert said.rstrip().endswith("KeyboardInterrupt")

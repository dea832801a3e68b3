"""A small sweep through all stages, in this process or as a command, and what has to hold after a fault."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future
from pathlib import Path

import pandas as pd

from datasets_gen.records import load_record
from evaluation import Experiment, ResultsStore, run
from evaluation.experiment.tasks import STAGES
from evaluation.results.result_files import FOLDERS
from evaluation.results.store import TIMING
from evaluation.running.cluster import Cluster
from tests.faults.light_stages import LIGHT, SECONDS

ROOT = Path(__file__).resolve().parents[2]
START = Path(__file__).resolve().parent / "start"
TASKS = 21
"""Of the sweep: 1 shape, 3 renders, 4 scans, 5 operators, 2 maps and 6 scores."""
ENDS_WITHIN = 240.0
"""Seconds in which a command has to end, on a machine that does much else."""


def experiment(folder: Path, timeout: float = 600.0) -> Experiment:
    """Three poses, one threshold, Eq. 18 and one method; a data set of files that nobody reads."""
    data, method = folder / "body", folder / "mine.py"
    data.mkdir(parents=True, exist_ok=True)
    for pose in ("rest", "bent", "curled"):
        (data / f"{pose}.ply").write_text("not read by these stages")
    method.write_text(
        "from dataclasses import dataclass\n"
        "from evaluation.methods import Method\n"
        "@dataclass(frozen=True, kw_only=True)\n"
        "class Mine(Method):\n"
        "    pass\n"
    )
    return Experiment.from_table(
        {
            "name": "small",
            "dataset": [{"name": str(data)}],
            "scan": {"points": 300, "views": 3},
            "stability": {"operators": ["heat"], "sweep": {"threshold": [0.2]}},
            "matching": {"sweep": {"threshold": [0.2]}},
            "method": [{"name": f"{method}:Mine", "label": "mine"}],
            "timeout": timeout,
        }
    )


class Here:
    """A client that runs what is submitted at once, in this process."""

    def nthreads(self):
        return {"here": 1}

    def submit(self, runner, *args, key, pure):
        future = Future()
        future.key, future.release = key, lambda: None
        future.set_result(runner(*args))
        return future


def run_here(settings, folder, monkeypatch, **options):
    """`evaluation.run` in this process, with light stages and without Dask."""

    @contextlib.contextmanager
    def connect(*_):
        yield Cluster(Here(), 1, "", 1.0)

    with monkeypatch.context() as patch:
        for stage, module in LIGHT.items():
            patch.setitem(STAGES, stage, module)
        patch.setattr("evaluation.running.run.connect", connect)
        patch.setattr("evaluation.running.run.versions", lambda: {})  # as slow as all the rest
        return run(settings, folder, **options)


def content(folder):
    """The table without what differs from run to run."""
    return ResultsStore(folder).table().drop(columns=list(TIMING))


def check_whole(folder):
    """Nothing half-written: every file that has a name of its own can be read, and no other is there."""
    for path in folder.rglob("*"):
        if path.is_dir() or path.name in (".lock", ".lock-holder"):
            continue
        assert not path.name.startswith("."), path
        if path.suffix == ".json":
            json.loads(path.read_text())
        elif path.suffix == ".npz":
            load_record(path, "Light")
        elif path.suffix == ".parquet":
            pd.read_parquet(path)


def check_finished(folder, expected):
    """The undisturbed table, all of the results, and nothing else."""
    store = ResultsStore(folder)
    assert store.failures().empty
    pd.testing.assert_frame_equal(content(folder), expected)
    assert store.is_merged()
    assert sum(len(list((folder / name).iterdir())) for name in FOLDERS.values()) == 2 * TASKS - len(expected)
    assert not list((folder / "running").glob("*"))
    assert store.run_info()["wall_seconds"] >= 0
    check_whole(folder)


def command(settings: Path, folder: Path, jobs: int = 1) -> list[str]:
    """The command line of a sweep."""
    words = ["run", str(settings), "-o", str(folder), "-j", str(jobs), "-q", "--no-report"]
    return [sys.executable, "-m", "tests.faults.command", *words]


def started(settings, folder, jobs=1, *, seconds=0.02, start=False, **options):
    """A sweep as a process of its own, in a process group of its own.

    Parameters
    ----------
    settings, folder, jobs
    seconds
        Of each task.
    start
        Whether ``start/sitecustomize.py`` is read.
    **options
        Of `subprocess.Popen`; ``env`` is added to the environment.
    """
    paths = [str(START), str(ROOT)] if start else [str(ROOT)]
    env = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(paths),
        SECONDS: str(seconds),
        **options.pop("env", {}),
    }
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(
        command(settings, folder, jobs), cwd=ROOT, env=env, start_new_session=True, **pipes, **options
    )


def ended(process):
    """What a sweep said on standard error, and its exit status; it and its workers are gone afterwards."""
    try:
        _, said = process.communicate(timeout=ENDS_WITHIN)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    return said, process.returncode


def results(folder):
    """Number of stored results."""
    return sum(len(list((folder / name).glob("[!.]*.json"))) for name in FOLDERS.values())


def wait_for(condition, process, seconds=120.0):
    """Wait until a condition holds or the process has ended; returns whether it runs still."""
    deadline = time.monotonic() + seconds
    while not condition() and process.poll() is None:
        assert time.monotonic() < deadline
        time.sleep(0.005)
    return process.poll() is None

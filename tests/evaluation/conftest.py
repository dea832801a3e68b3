"""A tiny data set and a method file for runs that take seconds."""

import pytest
import trimesh

from evaluation import Experiment
from tests.evaluation.meshes import blob

METHODS = r'''
import os, sys, time
from dataclasses import dataclass
import numpy as np
from evaluation.methods import Method, dense

@dataclass(frozen=True, kw_only=True)
class Nearest(Method):
    """Nearest neighbour in space; or trouble, on demand."""

    trouble: str = ""
    number: int = 0

    def match(self, source, target, seed):
        if self.trouble == "raise":
            raise RuntimeError("out of luck")
        if self.trouble == "hang":
            time.sleep(600)
        if self.trouble == "die":
            os.kill(os.getpid(), 9)
        if self.trouble == "leave":
            os._exit(0)
        if self.trouble == "fault":
            import ctypes
            ctypes.string_at(0)
        if self.trouble == "exit":
            sys.exit(3)
        if self.trouble == "interrupt":
            raise KeyboardInterrupt
        if self.trouble == "memory":
            raise MemoryError
        if self.trouble == "recursion":
            return self.match(source, target, seed)
        if self.trouble == "mute":
            class Mute(Exception):
                def __str__(self):
                    raise RuntimeError("no words")
            raise Mute
        if self.trouble == "garbled":
            raise ValueError("half \ud800\x1b[31m of\n it " + 2000 * "x")
        if self.trouble == "write":
            source.scan.points[:] = 0
        if self.trouble == "base":  # past every lock
            import ctypes
            for array in (source.points, target.points):
                array.base.setflags(write=True)
                array.base[:] = 0
                ctypes.memset(array.ctypes.data, 0, array.nbytes)
        if self.trouble == "settings":
            import random, warnings
            np.seterr(all="raise")
            warnings.simplefilter("error")
            os.umask(0o777)
            os.environ["HOME"] = "nowhere"
            random.seed(1), np.random.seed(1), sys.setrecursionlimit(500)
            return dense(np.zeros(len(source), int), np.ones(len(source)))
        if self.trouble == "note":
            source.scan.config.__dict__.clear()
        if self.trouble == "wrong":
            return dense(np.full(len(source), len(target)), np.ones(len(source)))
        from scipy.spatial import cKDTree
        distance, nearest = cKDTree(target.points).query(source.points)
        return dense(nearest, np.exp(-distance), seed=seed)
'''


@pytest.fixture(scope="session")
def blobs(tmp_path_factory):
    """A folder with three poses of a small body."""
    folder = tmp_path_factory.mktemp("data") / "blob"
    folder.mkdir()
    for pose, bend in (("rest", 0.0), ("bent", 0.5), ("curled", 0.9)):
        shape = blob(3, bend, pose)
        trimesh.Trimesh(shape.vertices, shape.faces, process=False).export(folder / f"{pose}.ply")
    return folder


@pytest.fixture(scope="session")
def method_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("methods") / "mine.py"
    path.write_text(METHODS)
    return path


@pytest.fixture
def small(blobs, method_file):
    """Makes an experiment of seconds; keyword arguments replace sections."""

    def make(**changes):
        table = {
            "name": "small",
            "dataset": [{"name": str(blobs)}],
            "scan": {"points": 300, "views": 3, "scanner": {"resolution": [60, 60], "stripes": 120}},
            "operators": {"modes": 30},
            "stability": {"operators": ["heat"], "sweep": {"threshold": [0.2, 0.7]}, "pairs": 500},
            "matching": {"sweep": {"threshold": [0.2]}},
            "method": [{"name": f"{method_file}:Nearest", "label": "nearest"}],
            "evaluated": 100,
            "timeout": 600.0,
        }
        return Experiment.from_table({**table, **changes})

    return make

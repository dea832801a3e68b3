"""What a method changes of its process is put back."""

import json  # noqa: F401 - taken out of sys.modules below
import os
import random
import resource
import sys
import warnings

import numpy as np
import pytest

from evaluation.running.surroundings import kept_surroundings


def state():
    mask = os.umask(0)
    os.umask(mask)
    return {
        "filters": list(warnings.filters),
        "errors": np.geterr(),
        "mask": mask,
        "folder": os.getcwd(),
        "environment": dict(os.environ),
        "depth": sys.getrecursionlimit(),
        "random": random.getstate(),
        "path": list(sys.path),
        "modules": sys.modules.get("json"),
        "files": resource.getrlimit(resource.RLIMIT_NOFILE),
        "numpy": str(np.random.get_state()),  # noqa: NPY002
    }


@pytest.mark.parametrize("fails", [False, True])
def test_all_of_it_is_put_back(tmp_path, fails):
    before = state()
    changed = {}
    with pytest.raises(RuntimeError) if fails else kept_surroundings(0), kept_surroundings(3):
        warnings.simplefilter("error")
        np.seterr(all="raise")
        os.umask(0o777)
        os.chdir(tmp_path)
        os.environ["MEDIALBENCH_TEST"] = "x"
        del os.environ["PATH"]
        sys.setrecursionlimit(before["depth"] + 7)
        sys.path.clear()
        del sys.modules["json"]
        resource.setrlimit(resource.RLIMIT_NOFILE, (100, before["files"][1]))
        changed.update(state())
        if fails:
            raise RuntimeError
    after = state()
    assert all(changed[name] != value for name, value in before.items())
    assert after == before


def test_a_process_whose_limits_cannot_be_put_back_is_ended(monkeypatch):
    """Only root raises a hard limit; the tasks after it would fail for what the method did."""

    class Ended(Exception):
        pass

    def end(code):
        raise Ended(code)

    def refused(number, limit):
        raise ValueError("not allowed to raise maximum limit")

    def lower():
        put(resource.RLIMIT_NOFILE, (soft // 2, hard))
        monkeypatch.setattr(resource, "setrlimit", refused)

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    put = resource.setrlimit
    monkeypatch.setattr(os, "_exit", end)
    try:
        with pytest.raises(Ended, match="1"), kept_surroundings(0):
            lower()
    finally:
        put(resource.RLIMIT_NOFILE, (soft, hard))


def test_global_random_numbers_follow_the_seed():
    def drawn(seed):
        with kept_surroundings(seed):
            return random.random(), np.random.rand()  # noqa: NPY002

    assert drawn(3) == drawn(3)
    assert drawn(3) != drawn(4)


def test_a_folder_that_is_gone_stays_gone(tmp_path):
    here = os.getcwd()
    folder = tmp_path / "gone"
    folder.mkdir()
    try:
        os.chdir(folder)
        folder.rmdir()
        with kept_surroundings(0):
            os.chdir(here)
        assert os.getcwd() == here
    finally:
        os.chdir(here)

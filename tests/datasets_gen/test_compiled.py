import os
import threading

import numba
import numpy as np
import pytest

from datasets_gen.compiled import compiled, grown, ranges, run_tasks, thread_count


def test_compiled_functions_work_where_nothing_can_be_cached(monkeypatch):
    """Numba refuses to cache when neither the package nor the user's cache folder is writable."""
    njit = numba.njit

    def unwritable(*args, **options):
        if options.get("cache"):
            raise RuntimeError("cannot cache function: no locator available")
        return njit(*args, **options)

    monkeypatch.setattr(numba, "njit", unwritable)

    @compiled()
    def double(x):
        return 2 * x

    assert double(21) == 42


@pytest.mark.parametrize(("openmp", "expected"), [("1", 1), ("3,1", 3), ("999", 4), ("", 4), ("many", 4)])
def test_thread_count_respects_the_environment(monkeypatch, openmp, expected):
    monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", 4)
    monkeypatch.setenv("OMP_NUM_THREADS", openmp)
    assert thread_count() == expected


@pytest.mark.parametrize("threads", [1, 4])
def test_tasks_keep_their_order(monkeypatch, threads):
    monkeypatch.setattr("datasets_gen.compiled.thread_count", lambda: threads)
    used = set()

    def work(a, b):
        used.add(threading.get_ident())
        return 10 * a + b

    assert run_tasks(work, [(k, 1) for k in range(50)]) == [10 * k + 1 for k in range(50)]
    assert threading.get_ident() in used if threads == 1 else threading.get_ident() not in used


def test_tasks_within_tasks_do_not_wait_for_each_other(monkeypatch):
    monkeypatch.setattr("datasets_gen.compiled.thread_count", lambda: 2)
    nested = run_tasks(lambda k: run_tasks(lambda j: (k, j), [(0,), (1,), (2,)]), [(k,) for k in range(6)])
    assert nested == [[(k, 0), (k, 1), (k, 2)] for k in range(6)]


def test_a_forked_child_has_threads_of_its_own(monkeypatch):
    monkeypatch.setattr("datasets_gen.compiled.thread_count", lambda: 2)
    run_tasks(abs, [(-1,), (-2,)])
    child = os.fork()
    if child == 0:
        os._exit(0 if run_tasks(abs, [(-1,), (-2,)]) == [1, 2] else 1)
    assert os.waitpid(child, 0)[1] == 0


def test_an_error_in_a_task_is_raised():
    with pytest.raises(ZeroDivisionError):
        run_tasks(lambda x: 1 / x, [(1,), (0,)])


def test_ranges_cover_everything_once():
    assert ranges(10, 4) == [(0, 4), (4, 8), (8, 10)]
    assert ranges(0, 4) == []


@pytest.mark.uncompiled
def test_a_grown_array_has_twice_the_room_and_begins_alike():
    larger = grown(np.array([3, 1, 2]))
    assert larger.shape == (6,)
    assert larger[:3].tolist() == [3, 1, 2]

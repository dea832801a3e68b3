import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from medial.matching import nearest as module
from medial.matching.nearest import nearest, nearest_sum_of_norms


@pytest.mark.uncompiled
@settings(max_examples=30, deadline=None)
@given(n=st.integers(1, 60), m=st.integers(1, 60), d=st.integers(1, 40), seed=st.integers(0, 99))
def test_nearest_is_exact(n, m, d, seed):
    rng = np.random.default_rng(seed)
    x, y = rng.normal(size=(n, d)), rng.normal(size=(m, d))
    index, distance = nearest(x, y)
    table = np.linalg.norm(x[:, None] - y, axis=2)
    np.testing.assert_allclose(table[np.arange(n), index], table.min(axis=1), rtol=1e-4)
    np.testing.assert_allclose(distance, table[np.arange(n), index])


def test_far_from_the_origin_digits_are_kept():
    rng = np.random.default_rng(0)
    x = rng.normal(size=(200, 3)) + 1e4
    index, _ = nearest(x + 1e-3 * rng.normal(size=x.shape), x)
    assert np.array_equal(index, np.arange(200))


def test_sum_of_norms_is_exact():
    rng = np.random.default_rng(1)
    x = [rng.normal(size=(70, 5)) for _ in range(3)]
    y = [rng.normal(size=(90, 5)) for _ in range(3)]
    index, distance = nearest_sum_of_norms(x, y)
    table = sum(np.linalg.norm(a[:, None] - b, axis=2) for a, b in zip(x, y, strict=True))
    np.testing.assert_array_equal(index, table.argmin(axis=1))
    np.testing.assert_allclose(distance, table.min(axis=1), rtol=1e-5)


@pytest.mark.parametrize("threads", [1, 3])
def test_threads_do_not_change_a_bit(monkeypatch, threads):
    rng = np.random.default_rng(2)
    x, y = rng.normal(size=(3000, 30)), rng.normal(size=(500, 30))
    expected = nearest_sum_of_norms([x], [y])
    monkeypatch.setattr("datasets_gen.compiled.thread_count", lambda: threads)
    found = nearest_sum_of_norms([x], [y])
    assert np.array_equal(expected[0], found[0])
    assert np.array_equal(expected[1], found[1])
    assert module.BLOCK == 1024

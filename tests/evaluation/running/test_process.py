import numpy as np
import pytest

from evaluation.running.process import peak_memory, single_thread


def test_peak_memory_of_a_block():
    with peak_memory() as small_block:
        np.ones(1000).sum()
    with peak_memory() as large_block:
        np.ones(25_000_000).sum()  # 200 MB
    if small_block.megabytes is None:
        pytest.skip("this system does not tell")
    assert 150 < large_block.megabytes - small_block.megabytes < 260


def test_one_thread_for_linear_algebra():
    from threadpoolctl import threadpool_info

    np.ones((2, 2)) @ np.ones((2, 2))
    with single_thread():
        assert {info["num_threads"] for info in threadpool_info() if info["user_api"] == "blas"} <= {1}

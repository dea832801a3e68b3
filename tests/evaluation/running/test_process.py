import os
import signal
import subprocess
import sys

import numpy as np
import pytest

from evaluation.running.process import hold_interrupts, peak_memory, polled_interrupts, single_thread


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


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals cannot be blocked here")
def test_ctrl_c_waits_for_the_end_of_the_block_and_does_not_reach_its_children():
    code = "import os, signal; os.kill(os.getpid(), signal.SIGINT); print('alive')"
    said, before = [], signal.getsignal(signal.SIGINT)

    def interrupted():
        with hold_interrupts():
            os.kill(os.getpid(), signal.SIGINT)
            said.append(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout)

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert said == ["alive\n"]
    assert signal.getsignal(signal.SIGINT) == before
    with hold_interrupts():
        pass
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, set())


class Interrupted:
    """Something whose finalizer is running when Ctrl-C is pressed, like that of Dask's futures."""

    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)


def test_ctrl_c_in_a_finalizer_is_not_lost(capsys):
    woken = []

    def block():
        with polled_interrupts(lambda: woken.append(1)) as check:
            check()
            Interrupted()  # ends here
            check()

    with pytest.raises(KeyboardInterrupt):
        block()
    assert woken == [1]
    assert capsys.readouterr().err == ""


def test_ctrl_c_is_raised_at_the_end_if_nothing_asked_for_it():
    with pytest.raises(KeyboardInterrupt), polled_interrupts():
        os.kill(os.getpid(), signal.SIGINT)


def test_ctrl_c_pressed_twice_is_raised_at_once():
    reached = []

    def block():
        with polled_interrupts():
            os.kill(os.getpid(), signal.SIGINT)
            reached.append("once")
            os.kill(os.getpid(), signal.SIGINT)
            reached.append("twice")

    with pytest.raises(KeyboardInterrupt):
        block()
    assert reached == ["once"]


def test_the_handler_is_as_before_after_the_block():
    before = signal.getsignal(signal.SIGINT)
    with polled_interrupts():
        assert signal.getsignal(signal.SIGINT) is not before
    assert signal.getsignal(signal.SIGINT) is before

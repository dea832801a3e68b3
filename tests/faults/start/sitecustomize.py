"""Faults of a Python process from its start; read by every process that has this folder in PYTHONPATH.

``MEDIALBENCH_TEST_CLOCK=SECONDS,YEARS`` makes `time.time` jump by years, so many seconds after the process
began. ``MEDIALBENCH_TEST_LOST=FOLDER`` ends, and ``MEDIALBENCH_TEST_STUCK=FOLDER`` stops, one worker process
for each file in a folder, which is removed, before it does anything.
"""

import os
import signal
import sys
import time
from pathlib import Path


def jump(seconds, years):
    clock, since, begin = time.time, time.monotonic, time.monotonic()
    time.time = lambda: clock() + (years * 31557600.0 if since() - begin > seconds else 0.0)


def taken(folder):
    """Whether a file of the folder could be removed by this process."""
    for path in Path(folder).iterdir():
        try:
            path.unlink()
            return True
        except FileNotFoundError:  # by another process
            pass
    return False


if "MEDIALBENCH_TEST_CLOCK" in os.environ:
    jump(*map(float, os.environ["MEDIALBENCH_TEST_CLOCK"].split(",")))
if "--multiprocessing-fork" in sys.argv or "spawn_main" in " ".join(sys.orig_argv):
    if "MEDIALBENCH_TEST_LOST" in os.environ and taken(os.environ["MEDIALBENCH_TEST_LOST"]):
        os._exit(1)
    if "MEDIALBENCH_TEST_STUCK" in os.environ and taken(os.environ["MEDIALBENCH_TEST_STUCK"]):
        os.kill(os.getpid(), signal.SIGSTOP)

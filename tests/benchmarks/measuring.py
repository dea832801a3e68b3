"""Time and peak memory of a call, and calls in a process of their own."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def measured(function, *args, **kwargs):
    """The result of a call; seconds, processor seconds and peak megabytes of the process during it."""
    forget_peak()
    start, busy = time.perf_counter(), time.process_time()
    result = function(*args, **kwargs)
    return result, [time.perf_counter() - start, time.process_time() - busy, peak_megabytes()]


def peak_megabytes():
    """Peak memory since `forget_peak`; None where the system does not tell."""
    if not STATUS.exists():
        return None
    return next(int(line.split()[1]) / 1024 for line in STATUS.read_text().splitlines() if "VmHWM" in line)


def forget_peak():
    try:
        RESET.write_text("5")
    except OSError:
        return


def in_own_process(module, *arguments, **environment):
    """What a module, run as a program, prints as JSON."""
    command = [sys.executable, "-m", module, *map(str, arguments)]
    done = subprocess.run(
        command, cwd=ROOT, env=os.environ | environment, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)

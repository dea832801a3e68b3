"""What run.json says of the software and the machine, and how many processors there are to use."""

import contextlib
import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from datasets_gen.fingerprints import library_versions
from evaluation.experiment.tasks import STAGES

RUNNING = ("medialbench", "dask", "distributed", "pandas")
"""Packages that run a plan; those that compute results are found from the code of the stages."""


def versions() -> dict[str, str]:
    """Versions of Python, of medialbench and of the libraries that results are computed with, by name."""
    found = {"python": platform.python_version()}
    for name in RUNNING:
        with contextlib.suppress(PackageNotFoundError):
            found[name] = version(name)
    return found | library_versions(*STAGES.values())


def machine() -> dict[str, str | int | None]:
    """Name, system, processor and number of cores of this machine."""
    return {
        "node": platform.node(),
        "system": platform.platform(),
        "processor": _processor(),
        "cores": os.cpu_count(),
    }


def usable_processors() -> int:
    """Processors that this process may use; all of the machine's where the system does not tell."""
    if hasattr(os, "sched_getaffinity"):  # not on Windows and macOS
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _processor() -> str:
    with contextlib.suppress(OSError):  # Linux only
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()

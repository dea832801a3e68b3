"""Which device computes: the processor, a GPU (CUDA), or the GPU's kernels on the processor (LLVM).

Dr.Jit translates one source of the kernels for both backends. It is imported only when a device other than
the processor is asked for. The device is never chosen automatically: results differ in their last digits
between devices and must not depend on the machine.
"""

import os
import subprocess
import sys
from functools import cache
from importlib import import_module
from typing import Any

from datasets_gen.compiled import thread_count
from datasets_gen.records import InputError

CPU, CUDA, LLVM = "cpu", "cuda", "llvm"
DEVICES = (CPU, CUDA, LLVM)
TIMEOUT = 60.0  # seconds after which a probe counts as failed
_PROBE = """
import drjit as dr
from drjit.llvm import Float, Float64
x = dr.arange(Float, 5) - 2
assert list(dr.minimum(x, 1)) == [-2, -1, 0, 1, 1] and list(dr.clip(x, -1, 1)) == [-1, -1, 0, 1, 1]
assert list(dr.sqrt(Float64(4.0, 9.0))) == [2, 3]
"""


def check_device(device: str) -> None:
    """Raise `InputError` if there is no device of that name; whether it works here is not tried."""
    if device not in DEVICES:
        raise InputError(f"unknown device {device!r}; choose one of {', '.join(DEVICES)}")


@cache
def backend(device: str) -> Any:
    """The Dr.Jit module of a device, ``drjit.cuda`` or ``drjit.llvm``, known to work.

    Parameters
    ----------
    device : {"cuda", "llvm"}

    Raises
    ------
    InputError
        If what the device needs is missing on this machine.
    """
    if device == LLVM and (reason := _llvm_fault()):
        raise InputError(
            f"device 'llvm' needs a libLLVM of version 16 or newer ({reason}): install one (Debian: apt-get "
            "install libllvm19), name it in DRJIT_LIBLLVM_PATH, or use device 'cpu'"
        )
    import drjit as dr

    if device == CUDA and not dr.has_backend(dr.JitBackend.CUDA):
        raise InputError("device 'cuda' needs an NVIDIA GPU and its driver, not found here; use device 'cpu'")
    if device == LLVM and thread_count() < dr.thread_count():
        dr.set_thread_count(thread_count())
    return import_module(f"drjit.{device}")


@cache
def _llvm_fault() -> str:
    """Why the LLVM backend cannot be used, or an empty string: tried in a child, as old ones abort."""
    environment = os.environ | {"DRJIT_NO_LOG": "1"}
    try:
        done = subprocess.run(
            [sys.executable, "-c", _PROBE],
            env=environment,
            capture_output=True,
            text=True,
            timeout=TIMEOUT,
            check=False,
        )
    except (subprocess.TimeoutExpired, OSError) as error:
        return f"trying it failed: {type(error).__name__}"
    if done.returncode < 0:
        return f"trying it was ended by signal {-done.returncode}"
    if done.returncode == 0:
        return ""
    lines = done.stderr.strip().splitlines() or ["trying it failed"]
    return "none was found" if "could not be found" in lines[-1] else lines[-1].strip()

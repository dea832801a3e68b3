"""Devices other than the processor: tests that take one are skipped where it does not work."""

import pytest

from datasets_gen.records import InputError
from medial.device.backend import backend

on_each = pytest.mark.parametrize("device", ["llvm", "cuda"])


def require(device):
    """The Dr.Jit module of a device; skips with the reason where there is none."""
    try:
        return backend(device)
    except InputError as error:
        pytest.skip(str(error))

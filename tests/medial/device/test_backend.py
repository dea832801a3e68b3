"""What is said where a device is missing, without ending the process, and what is not imported."""

import subprocess
import sys

import drjit as dr
import numpy as np
import pytest

from datasets_gen.records import InputError
from medial import Diffusion, similarity
from medial.device import backend as devices
from medial.operator import Operator
from medial.spectrum.modes import smallest_modes
from tests.medial import clouds
from tests.medial.spectrum.test_modes import ring


@pytest.fixture(autouse=True)
def forgotten():
    """Nothing is remembered from or for other tests."""
    for function in (devices.backend, devices._llvm_fault):
        function.cache_clear()
    yield
    for function in (devices.backend, devices._llvm_fault):
        function.cache_clear()


@pytest.fixture
def no_gpu(monkeypatch):
    monkeypatch.setattr(dr, "has_backend", lambda backend: False)


@pytest.mark.parametrize(
    "call",
    [
        lambda: similarity(*clouds.sphere(50), device="cuda"),
        lambda: Diffusion.from_points(*clouds.body(300), modes=5, device="cuda"),
        lambda: smallest_modes(ring(1300), np.ones(1300), 5, device="cuda"),
    ],
    ids=["similarity", "operator", "modes"],
)
def test_no_gpu(no_gpu, call):
    with pytest.raises(InputError, match=r"NVIDIA GPU and its driver.*use device 'cpu'") as error:
        call()
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("probe", "reason"),
    [
        ("import os; os.abort()", "ended by signal 6"),
        ("raise RuntimeError('libLLVM could not be found!')", "none was found"),
        ("assert False, 'wrong'", "AssertionError: wrong"),
        ("import time; time.sleep(60)", "TimeoutExpired"),
    ],
)
def test_unsound_libllvm(monkeypatch, probe, reason):
    monkeypatch.setattr(devices, "_PROBE", probe)
    monkeypatch.setattr(devices, "TIMEOUT", 0.5 if "sleep" in probe else 60)
    with pytest.raises(InputError, match=rf"libLLVM.*\(.*{reason}\).*use device 'cpu'") as error:
        similarity(*clouds.sphere(50), device="llvm")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "call",
    [
        lambda: similarity(*clouds.sphere(50), device="gpu"),
        lambda: Operator(device="gpu"),
        lambda: smallest_modes(ring(100), np.ones(100), 5, device="gpu"),
    ],
    ids=["similarity", "operator", "modes"],
)
def test_unknown_device(call):
    with pytest.raises(InputError, match="unknown device 'gpu'; choose one of cpu, cuda, llvm"):
        call()


def test_drjit_is_not_imported_for_the_processor():
    code = """
import sys
import numpy as np
from medial import Diffusion, similarity
points = np.random.default_rng(0).normal(size=(50, 3))
similarity(points, points)
assert "drjit" not in sys.modules
"""
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_processor_is_the_default():
    assert Operator().device == "cpu"
    points, normals = clouds.body(300)
    assert (similarity(points, normals) != similarity(points, normals, device="cpu")).nnz == 0

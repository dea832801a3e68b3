"""Scenes come and go: memory stays flat over hundreds of scans."""

import resource
from pathlib import Path

import pytest

from scanner_sim import ScannerConfig, scan


def resident():
    """Resident set in MiB."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 2**20


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs Linux's /proc")
def test_memory_is_flat_over_300_scans(capsule, torus, each_variant):
    config = ScannerConfig(views=1, resolution=(64, 64), stripes=100)
    for shape in [capsule, torus] * 10:
        scan(shape, config)
    before = resident()
    for shape in [capsule, torus] * 150:
        scan(shape, config)
    assert resident() < 1.05 * before

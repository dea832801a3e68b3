"""Speed of the scanner as ratios within one run: variants, threshold sweeps, and rendering every stripe."""

import sys
from time import perf_counter

import numpy as np
import pytest

import datasets_gen
from scanner_sim import ScannerConfig, scan
from scanner_sim.scanner import Rig
from scanner_sim.tracing import brute_force, variant

CONFIG = ScannerConfig(views=10, resolution=(640, 480), stripes=400, peak_threshold=0.01)
THRESHOLDS = np.linspace(0.1, 0.9, 9)


@pytest.fixture(scope="module")
def body():
    return datasets_gen.load("human").reference


@pytest.fixture(params=[variant.SCALAR, variant.LLVM, variant.CUDA])
def name(request, monkeypatch):
    outcome = variant.probe(request.param)[-1]
    if not outcome.works:
        pytest.skip(outcome.reason)
    monkeypatch.setattr(variant, "choose", lambda: request.param)
    return request.param


def say(benchmark, **figures):
    """Note figures in the record and show them; `make perf` runs with -s."""
    benchmark.extra_info.update(figures)
    sys.stdout.write(
        "\n" + benchmark.name + ": " + ", ".join(f"{k} {v:,}" for k, v in figures.items()) + "\n"
    )


def seconds(function, repeats=3):
    """Shortest time of a few calls after a first one."""
    function()
    times = []
    for _ in range(repeats):
        start = perf_counter()
        function()
        times.append(perf_counter() - start)
    return min(times)


def test_scan(benchmark, body, name):
    """Goal on 2 cores: about 400k lit pixels per second with LLVM, at least a fifth of it without."""
    lit = len(scan(body, CONFIG))  # also warms up
    benchmark.pedantic(scan, args=(body, CONFIG), rounds=5)
    least = benchmark.stats["min"]
    say(benchmark, lit_pixels=lit, seconds=round(least, 2), lit_pixels_per_second=round(lit / least))


def test_threshold_sweep(benchmark, body):
    """A further threshold costs less than 5 % of the scan."""
    found = scan(body, CONFIG)
    whole = seconds(lambda: scan(body, CONFIG))
    benchmark.pedantic(lambda: [found.accept(t) for t in THRESHOLDS], rounds=5)
    share = benchmark.stats["min"] / len(THRESHOLDS) / whole
    say(benchmark, percent_of_scan_per_threshold=round(100 * share, 2))
    assert share < 0.05


def test_synthesis_against_rendering_every_stripe(benchmark, body, name):
    """One view by synthesis is at least 100 times faster than by rendering its stripes."""
    rig = Rig(body, CONFIG)
    hits, _ = rig.view(0, seed=0)
    some = np.arange(100, 300, 20)
    rendering = seconds(lambda: brute_force.render(rig.tracer, rig.poses[0], hits.pixels, some), repeats=1)
    benchmark.pedantic(rig.view, args=(0, 0), rounds=5)
    ratio = rendering / len(some) * CONFIG.stripes / benchmark.stats["min"]
    say(benchmark, times_faster=round(ratio))
    assert ratio > 100

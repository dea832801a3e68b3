"""How long the medial operator takes, how much memory it needs, and how both grow: printed by `make perf`."""

import sys

import numpy as np
import pytest

from tests.benchmarks.measuring import in_own_process
from tests.medial.devices import require

SIZES = (5000, 10_000, 20_000, 40_000, 80_000)
PLAIN_UP_TO = 10_000
STAGES = ("surface", "similarity", "axis", "areas", "gaussian", "combination", "laplacian", "modes")
reports: dict[int, dict] = {}
on_gpu: dict[int, dict] = {}


def say(line=""):
    sys.stdout.write(line + "\n")


def measure(points, *options, **environment):
    plain = ["--plain"] if points <= PLAIN_UP_TO and not options else []
    return in_own_process("tests.benchmarks.operator_stages", points, *plain, *options, **environment)


@pytest.mark.parametrize("points", SIZES)
def test_operator(benchmark, points):
    reports[points] = benchmark.pedantic(measure, args=(points,), rounds=1)
    assert reports[points]["residual"] < 1e-6


@pytest.mark.parametrize("points", SIZES)
def test_operator_on_a_gpu(benchmark, points):
    require("cuda")
    on_gpu[points] = benchmark.pedantic(measure, args=(points, "--cuda"), rounds=1)
    assert on_gpu[points]["residual"] < 1e-6


def test_first_call_without_a_cache(benchmark, tmp_path):
    """Compiling everything, as after installation."""
    cache = {"NUMBA_CACHE_DIR": str(tmp_path)}
    report = benchmark.pedantic(measure, args=(1300,), kwargs=cache, rounds=1)
    say(f"\nfirst call with an empty cache: {report['first call']:.1f} s")


def test_table(benchmark):
    """Not a measurement: prints what the others measured."""
    benchmark.pedantic(lambda: None, rounds=1)
    if not reports:
        pytest.skip("nothing was measured")
    say("\n\nmedial operator, 300 modes: seconds / processor seconds (peak MB of the process); G: on a GPU")
    say("points  " + "".join(f"{stage:>21}" for stage in STAGES) + "   phi/row sigma/row  plain/fast")
    rows = [(str(points), report) for points, report in reports.items()]
    for name, report in rows + [(f"{points} G", report) for points, report in on_gpu.items()]:
        cells = "".join(
            f"{report[stage][0]:7.2f}/{report[stage][1]:6.2f} {_megabytes(report[stage]):>6}"
            for stage in STAGES
        )
        plain = f"{report['plain'][1] / report['similarity'][1]:9.1f}x" if "plain" in report else " " * 10
        say(f"{name:<8}{cells} {report['phi per row']:9.0f} {report['sigma per row']:9.0f}  {plain}")
    if len(reports) > 1:
        say("growth  " + "".join(f"{f'n^{_growth(stage):.2f}':>21}" for stage in STAGES))
    assert all(report.get("difference", 0) < 5e-5 for report in reports.values())


def _megabytes(pair):
    return f"({pair[2]:.0f})" if pair[2] else ""


def _growth(stage):
    sizes = np.log(list(reports))
    return np.polyfit(sizes, np.log([max(report[stage][1], 1e-4) for report in reports.values()]), 1)[0]

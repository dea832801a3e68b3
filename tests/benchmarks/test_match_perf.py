"""How long a match takes (operators given), how much memory, and how both grow: printed by `make perf`."""

import sys

import numpy as np
import pytest

from tests.benchmarks.measuring import in_own_process

STAGES = "tests.benchmarks.match_stages"
SIZES = (2500, 5000, 10_000, 20_000)
reports: dict[int, dict] = {}


@pytest.mark.parametrize("points", SIZES)
def test_match(benchmark, points):
    reports[points] = benchmark.pedantic(in_own_process, args=(STAGES, points), rounds=1)
    assert reports[points]["error"] < 5


def test_table(benchmark):
    """Not a measurement: prints what the others measured."""
    benchmark.pedantic(lambda: None, rounds=1)
    if not reports:
        pytest.skip("nothing was measured")
    lines = [
        "",
        "",
        "match of two scans, human, 20 % missing",
        "points  wall s  processor s  peak MB  error x100",
    ]
    lines += [
        f"{r['points']:6.0f}{r['wall']:8.1f}{r['processor']:13.1f}{r['peak MB'] or 0:9.0f}{r['error']:12.2f}"
        for r in reports.values()
    ]
    if len(reports) > 1:
        sizes = np.log([r["points"] for r in reports.values()])
        growth = np.polyfit(sizes, np.log([r["processor"] for r in reports.values()]), 1)[0]
        lines.append(f"processor time grows as n^{growth:.2f}")
    sys.stdout.write("\n".join(lines) + "\n")

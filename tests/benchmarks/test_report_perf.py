"""The report of 500 maps: time, memory and size of the page."""

import os
import resource
import sys

import reports
from tests.reports.conftest import write_results

SEEDS = int(os.environ.get("MEDIALBENCH_MAPS", "500")) // 4
"""Each seed has two thresholds and two methods."""


def test_report_of_many_maps(benchmark, tmp_path):
    """With the default number of pairs drawn; small scans, so that drawing the pairs is not what counts."""
    folder = tmp_path / "results"
    write_results(folder, seeds=range(SEEDS))
    index = benchmark.pedantic(reports.build, (folder,), rounds=1)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    whole = sum(file.stat().st_size for file in index.parent.rglob("*.js")) + index.stat().st_size
    figures = {
        "maps": 4 * SEEDS,
        "seconds": round(benchmark.stats.stats.max, 1),
        "peak_memory_mb": round(peak),
        "page_mb": round(index.stat().st_size / 1e6, 2),
        "with_views_mb": round(whole / 1e6, 2),
    }
    benchmark.extra_info.update(figures)
    sys.stdout.write("\nreport: " + ", ".join(f"{k} {v}" for k, v in figures.items()) + "\n")

"""What each stage of a run took: seconds and memory of its tasks, from the records of a results folder."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from datasets_gen.records import InputError
from evaluation.experiment.tasks import STAGES
from evaluation.results.result_files import FOLDERS
from evaluation.results.store import ResultsStore
from reports.figures.style import QUIET, new_figure, styled

WORDS = {
    "shape": "shapes",
    "render": "what the scanner sees",
    "scan": "scans",
    "operator": "operators",
    "map": "maps",
    "score": "scores",
}
COLOR = "#0072b2"


def stage_costs(store: ResultsStore) -> pd.DataFrame:
    """Cost of every stage of a run.

    Parameters
    ----------
    store

    Returns
    -------
    DataFrame
        A row per stage with results: ``tasks``, ``seconds`` and ``cpu_seconds`` (sums), ``median_seconds``,
        ``peak_memory_mb`` (greatest; nan if unknown), ``megabytes`` (of all files).

    Raises
    ------
    InputError
        If the folder holds no records.
    """
    rows = []
    for stage in STAGES:
        keys = sorted(path.stem for path in (store.folder / FOLDERS[stage]).glob("[!.]*.json"))
        found = [record for key in keys if (record := store.record(stage, key)) is not None]
        if not found:
            continue
        seconds = [float(record["seconds"]) for record in found]
        peaks = [float(p) for record in found if (p := record["peak_memory_mb"]) is not None]
        rows.append(
            {
                "stage": stage,
                "tasks": len(found),
                "seconds": sum(seconds),
                "cpu_seconds": sum(float(record["cpu_seconds"]) for record in found),
                "median_seconds": float(np.median(seconds)),
                "peak_memory_mb": max(peaks, default=np.nan),
                "megabytes": sum(record["bytes"] or 0 for record in found) / 1e6,
            }
        )
    if not rows:
        raise InputError(f"{str(store.folder)!r} holds no records of tasks; give the folder of a run")
    return pd.DataFrame(rows)


@styled
def stage_cost(costs: pd.DataFrame) -> Figure:
    """Total time, median time of a task and peak memory of every stage.

    Parameters
    ----------
    costs
        Of `stage_costs`.
    """
    shown = [
        ("seconds", "time of all tasks, seconds"),
        ("median_seconds", "median time of a task, seconds"),
        ("peak_memory_mb", "greatest peak memory, MB"),
    ]
    shown = [each for each in shown if costs[each[0]].notna().any()]
    figure, grid = new_figure(1, len(shown), 1.4 + 2.4 * len(shown), 0.3 * len(costs) + 0.95, sharey=True)
    places = np.arange(len(costs))[::-1]
    for axes, (column, title) in zip(grid[0], shown, strict=True):
        values = costs[column].to_numpy(float)
        axes.barh(places, np.nan_to_num(values), color=COLOR, height=0.62)
        for place, value in zip(places, values, strict=True):
            words = "unknown" if np.isnan(value) else f"{value:,.3g}" if value < 1000 else f"{value:,.0f}"
            axes.text(np.nan_to_num(value), place, f" {words}", va="center", fontsize=7, color=QUIET)
        axes.set_xlim(0, 1.22 * max(float(np.nanmax(np.append(values, 0.0))), 1e-9))
        axes.set_title(title, fontsize=8.5)
        axes.grid(False, axis="y")
    names = [f"{WORDS[row.stage]} ({row.tasks:,})" for row in costs.itertuples()]
    grid[0][0].set_yticks(places, names)
    return figure

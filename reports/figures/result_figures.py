"""Figures beyond the paper, of a results folder: what each is made of, and writing it with its numbers."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from datasets_gen.records import InputError
from evaluation.metrics.correspondence import CURVE
from evaluation.results.origin import Origin, write_csv
from evaluation.results.store import ResultsStore
from reports.figures.confidence_calibration import calibration_table, confidence_calibration
from reports.figures.error_against_missing import error_against_missing, scored_maps
from reports.figures.failure_rates import KINDS, failure_rates, rates_of_failure
from reports.figures.figure_request import MadeFigure
from reports.figures.pair_pictures import PairMaker
from reports.figures.pck_curves import pck_curves
from reports.figures.runtime_against_size import WHAT, runtime_against_size, runtimes
from reports.figures.stage_cost import stage_cost, stage_costs
from reports.figures.style import save
from reports.tables.leaderboard import with_numpy_types

Maker = Callable[[ResultsStore, pd.DataFrame], MadeFigure]

PAIR = ["dataset", "regime", "seed", "source_scan", "target_scan"]
"""Columns that name a pair of scans."""


def _missing(_: ResultsStore, maps: pd.DataFrame) -> MadeFigure:
    columns = ["dataset", "regime", "method", "seed", "source_missing", "target_missing", "geodesic_mean"]
    scored = scored_maps(maps)
    if scored.empty:
        raise InputError("no map of these results has an error and a missing share; run them again")
    return MadeFigure(error_against_missing(scored), scored[columns], {})


def _pck(store: ResultsStore, maps: pd.DataFrame) -> MadeFigure:
    curves: dict[str, dict[str, np.ndarray]] = {}
    for (dataset, method), rows in maps.groupby(["dataset", "method"], sort=False):
        stack = [store.score(str(key))["curve"] for key in rows["score_key"]]
        curves.setdefault(str(dataset), {})[str(method)] = np.mean(stack, axis=0)
    parts = [
        pd.DataFrame({"dataset": dataset, "method": method, "radius": 100 * CURVE, "share": curve})
        for dataset, lines in curves.items()
        for method, curve in lines.items()
    ]
    return MadeFigure(pck_curves(curves, 100 * CURVE), pd.concat(parts, ignore_index=True), {})


def _failures(_: ResultsStore, maps: pd.DataFrame) -> MadeFigure:
    rates = rates_of_failure(maps)
    if rates.empty:
        raise InputError(
            "these results tell neither swapped sides nor gross failures; run them again with this version"
        )
    return MadeFigure(failure_rates(rates), rates, {})


def _calibration(store: ResultsStore, maps: pd.DataFrame) -> MadeFigure:
    maker = PairMaker(store)
    found: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for _, rows in maps.groupby(PAIR, sort=False):
        for each in maker.read(rows).maps:
            found.setdefault(str(each.row["method"]), []).append((each.found.confidence, each.errors))
    points = {
        method: (np.concatenate([c for c, _ in parts]), np.concatenate([e for _, e in parts]))
        for method, parts in found.items()
    }
    table = calibration_table(points)
    return MadeFigure(confidence_calibration(table), table, {})


def _runtime(_: ResultsStore, maps: pd.DataFrame) -> MadeFigure:
    table = runtimes(maps)
    if table.empty:
        raise InputError("these results hold no times; run them again with this version")
    return MadeFigure(runtime_against_size(table), table, {})


def _stages(store: ResultsStore, _: pd.DataFrame) -> MadeFigure:
    costs = stage_costs(store)
    return MadeFigure(stage_cost(costs), costs, {})


MAKERS: dict[str, Maker] = {
    "missing": _missing,
    "pck": _pck,
    "failures": _failures,
    "calibration": _calibration,
    "runtime": _runtime,
    "stages": _stages,
}
"""Maker of each figure by its name; it gets the store and the rows of its maps."""
TITLES = {
    "failures": (
        "Failures",
        "Maps that swap left and right, and gross failures; whiskers are 95 % intervals.",
    ),
    "runtime": ("Time against points", "Medians, and whiskers from the least to the greatest time."),
    "stages": (
        "Cost of the stages",
        "Of the tasks whose results are in this folder; their number in brackets.",
    ),
}
"""Title and caption of the figures that the page shows beside its own."""
FILES = {
    "missing": "error-missing",
    "pck": "pck",
    "failures": "failure-rates",
    "calibration": "confidence-calibration",
    "runtime": "runtime-size",
    "stages": "stage-cost",
}


def has_figure(name: str, store: ResultsStore, maps: pd.DataFrame) -> bool:
    """Whether results hold what a figure of `TITLES` shows."""
    if name == "stages":
        return any((store.folder / "maps").glob("[!.]*.json"))
    columns = KINDS if name == "failures" else WHAT
    return any(column in maps and maps[column].notna().any() for column in columns)


def result_figure(name: str, store: ResultsStore) -> MadeFigure:
    """Make a figure of a results folder.

    Parameters
    ----------
    name
        One of `MAKERS`.
    store

    Raises
    ------
    InputError
        If the folder holds no maps, or not what the figure shows.
    """
    table = with_numpy_types(store.table())
    maps = table[table["kind"] == "matching"]
    if maps.empty and name != "stages":
        raise InputError(
            f"{str(store.folder)!r} holds no maps, which figure {name!r} shows; run some methods"
        )
    return MAKERS[name](store, maps)


def write_result_figure(name: str, store: ResultsStore, folder: Path) -> list[Path]:
    """Write a figure of a results folder as PDF and PNG, and the numbers behind it as CSV.

    Parameters
    ----------
    name, store
        As for `result_figure`.
    folder
        Files there of the same name are replaced.
    """
    made = result_figure(name, store)
    paths = save(made.figure, folder, FILES[name])
    table = folder / f"{FILES[name]}.csv"
    write_csv(made.table, table, Origin.of_run(store.run_info()))
    return [*paths, table]

"""Which figures a report has: one job each, made from the results table alone; drawn when called."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from evaluation.metrics import CURVE
from evaluation.store import ResultsStore
from reports.correspondence import PairMaker
from reports.figures.accuracy import error_against_missing, pck
from reports.figures.pairs import correspondence
from reports.figures.scans import ScanView, scans
from reports.figures.stability import stability
from reports.figures.style import save

POSES, THRESHOLDS = 3, 6
"""Rows and columns of the picture of scans."""


@dataclass(frozen=True)
class Picture:
    """A figure on the page: file name without suffix, head, caption, and what readers may filter by."""

    name: str
    title: str
    caption: str = ""
    group: str = ""


@dataclass(frozen=True)
class Job:
    """A figure to be drawn: the section it belongs to, what it shows, and the call that draws it."""

    section: str
    label: str
    draw: Callable[[], Picture]


def jobs(store: ResultsStore, table: pd.DataFrame, folder: Path, pairs: int | None) -> list[Job]:
    """Figures of a report, in the order of the page.

    Parameters
    ----------
    store, table
        A results folder and its table.
    folder
        Where the figures go.
    pairs
        Largest number of pairs to draw, None for all.
    """
    stable, maps = table[table["kind"] == "stability"], table[table["kind"] == "matching"]
    found = []
    if not maps.empty:
        found.append(Job("missing", "error against missing surface", partial(_missing, maps, folder)))
        found.append(Job("pck", "PCK curves", partial(_pck, store, maps, folder)))
    for dataset, rows in stable[stable["source_threshold"].notna()].groupby("dataset", sort=False):
        found.append(
            Job("stability", f"Eq. 18 of {dataset}", partial(_stability, str(dataset), rows, folder))
        )
    for dataset, views in scan_views(table).groupby("dataset", sort=False):
        found.append(Job("scans", f"scans of {dataset}", partial(_scans, store, str(dataset), views, folder)))
    maker = PairMaker(store)
    for number, rows in enumerate(chosen_pairs(maps, pairs), start=1):
        first = rows.iloc[0]
        label = f"{first['dataset']}: {first['source_pose']} to {first['target_pose']}"
        found.append(Job("pairs", label, partial(_pair, maker, rows, f"pair-{number:03d}", folder)))
    return found


def pair_groups(maps: pd.DataFrame) -> list[pd.DataFrame]:
    """Rows of the table by pair of scans, in the table's order."""
    keys = ["dataset", "regime", "seed", "source_scan", "target_scan"]
    return [rows for _, rows in maps.groupby(keys, sort=False)] if not maps.empty else []


def chosen_pairs(maps: pd.DataFrame, limit: int | None) -> list[pd.DataFrame]:
    """At most `limit` pairs, spread evenly over data sets and regimes; the first ones of each."""
    groups = pair_groups(maps)
    if limit is None or len(groups) <= limit:
        return groups
    seen: dict[tuple[str, str], int] = {}
    rank = []
    for number, rows in enumerate(groups):
        kind = (str(rows.iloc[0]["dataset"]), str(rows.iloc[0]["regime"]))
        seen[kind] = seen.get(kind, -1) + 1
        rank.append((seen[kind], number))
    return [groups[number] for number in sorted(number for _, number in sorted(rank)[:limit])]


def scan_views(table: pd.DataFrame) -> pd.DataFrame:
    """Scans of the first seed at the most frequent views: dataset, pose, threshold, missing, views, key."""
    columns = ["dataset", "pose", "threshold", "missing", "views", "seed", "key"]
    parts = []
    for side in ("source", "target"):
        names = [f"{side}_{c}" for c in ("pose", "threshold", "missing")]
        wanted = ["dataset", *names, "views", "seed", f"{side}_scan"]
        if set(wanted) <= set(table.columns):
            parts.append(table[wanted].set_axis(columns, axis=1))
    scans = pd.concat(parts).dropna(subset=["threshold", "key", "missing"]).drop_duplicates("key")
    if scans.empty:
        return scans
    usual = scans.groupby("dataset")["views"].agg(lambda views: views.mode().iloc[0])
    scans = scans[(scans["views"] == scans["dataset"].map(usual)) & (scans["seed"] == scans["seed"].min())]
    return scans.drop_duplicates(["dataset", "pose", "threshold"])


def spread(values: list[float], count: int) -> list[float]:
    """At most `count` of the sorted values, evenly spread, with the first and the last."""
    ordered = sorted(values)
    if len(ordered) <= count:
        return ordered
    return [ordered[round(i)] for i in np.linspace(0, len(ordered) - 1, count)]


def _missing(maps: pd.DataFrame, folder: Path) -> Picture:
    save(error_against_missing(maps), folder, "error-missing")
    return Picture(
        "error-missing",
        "Error against missing surface",
        "One dot per map; lines join the medians of groups of equal size.",
    )


def _pck(store: ResultsStore, maps: pd.DataFrame, folder: Path) -> Picture:
    curves: dict[str, dict[str, np.ndarray]] = {}
    for (dataset, regime, method), rows in maps.groupby(["dataset", "regime", "method"], sort=False):
        stack = [store.score(str(key))["curve"] for key in rows["score_key"]]
        curves.setdefault(f"{dataset}, {regime}", {})[str(method)] = np.mean(stack, axis=0)
    save(pck(curves, 100 * CURVE), folder, "pck")
    return Picture("pck", "PCK curves", "Share of points whose match lies within a radius, mean over maps.")


def _stability(dataset: str, rows: pd.DataFrame, folder: Path) -> Picture:
    name = f"stability-{_file_name(dataset)}"
    save(stability(rows), folder, name)
    return Picture(
        name, dataset, "A line per pose; dashed and on the right axis, the missing surface.", dataset
    )


def _scans(store: ResultsStore, dataset: str, views: pd.DataFrame, folder: Path) -> Picture:
    thresholds = spread(list(views["threshold"].unique()), THRESHOLDS)
    counts = views[views["threshold"].isin(thresholds)].groupby("pose", sort=False).size()
    poses = list(counts[counts == counts.max()].index[:POSES])
    rows, up = [], 1
    for pose in poses:
        row = []
        for threshold in thresholds:
            for _, view in views[(views["pose"] == pose) & (views["threshold"] == threshold)].iterrows():
                scan = store.scan(str(view["key"]))
                up = "xyz".index(scan.config.up)
                about = f"{100 * view['missing']:.0f} % missing"
                row.append(ScanView(scan.points, scan.normals, f"τ = {threshold:g}", about))
        rows.append((str(pose), row))
    name = f"scans-{_file_name(dataset)}"
    save(scans(rows, up), folder, name)
    what = f"{views['views'].iloc[0]} views; what shows through a hole is the inside, in grey."
    return Picture(name, dataset, what, dataset)


def _pair(maker: PairMaker, rows: pd.DataFrame, name: str, folder: Path) -> Picture:
    first = rows.iloc[0]
    save(correspondence(maker.make(rows)), folder, name)
    title = f"{first['dataset']}: {first['source_pose']} → {first['target_pose']}"
    seed = f", seed {first['seed']}" if int(first["seed"]) else ""
    return Picture(name, title, f"{first['regime']}{seed}", f"{first['dataset']}, {first['regime']}")


def _file_name(text: str) -> str:
    return "".join(c if c.isalnum() or c in "-_" else "-" for c in text)

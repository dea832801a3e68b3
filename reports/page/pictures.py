"""The figures of a report: which there are, by the results table, and drawing them."""

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from datasets_gen.fingerprints import digest
from evaluation.experiment.config_sections import SURFACE
from evaluation.metrics.correspondence import CURVE
from evaluation.results.store import ResultsStore
from evaluation.running.process import hold_interrupts
from reports.figures.diffusion_error_curves import diffusion_error_curves
from reports.figures.error_against_missing import error_against_missing, scored_maps
from reports.figures.method_comparison import method_comparison
from reports.figures.pair_pictures import PairMaker, pair_picture
from reports.figures.pck_curves import pck_curves
from reports.figures.result_figures import FILES, MAKERS, TITLES, has_figure
from reports.figures.scan_series import ScanView, scan_series
from reports.figures.style import save
from reports.page.page_rows import mean_curves, pair_key
from reports.viewer.packing import packed
from reports.viewer.pair_views import view_of_pair

FEW = 8
"""Figures that are drawn without starting processes, which takes some seconds."""

POSES, THRESHOLDS = 3, 6
"""Rows and columns of the picture of scans."""


@dataclass(frozen=True)
class PagePicture:
    """A figure on the page.

    Attributes
    ----------
    name : str
        File name without suffix.
    title, caption : str
    width : float
        Inches.
    group : str
        What readers may filter by; empty if alone.
    error : float
        Lowest mean error of the maps on it; nan if there are none.
    pair : str
        Which scans (`reports.page.page_rows.pair_key`); empty if none.
    view : str
        The same as a packed scene of the viewer (`reports.viewer.packing`); empty where there is none.
    """

    name: str
    title: str
    caption: str
    width: float
    group: str = ""
    error: float = float("nan")
    pair: str = ""
    view: str = ""


@dataclass(frozen=True)
class FigureJob:
    """A figure to be drawn: the section it belongs to, what it shows, and the call that draws it."""

    section: str
    label: str
    draw: Callable[[], PagePicture]


@dataclass(frozen=True)
class Drawing:
    """What a process needs to find the same jobs again: see `figure_jobs`."""

    results: Path
    folder: Path
    pairs: int | None


def drawn(
    todo: Sequence[FigureJob], drawing: Drawing, processes: int
) -> Iterator[tuple[FigureJob, PagePicture]]:
    """Draw figures, in the order of the jobs, with several processes where that pays."""
    if processes < 2 or len(todo) < FEW:
        yield from ((job, job.draw()) for job in todo)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, context, _prepare, (drawing,)) as pool:
        try:
            with hold_interrupts():  # they end with the pool, and say nothing
                pictures = pool.map(_draw, range(len(todo)))
            yield from zip(todo, pictures, strict=True)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


_todo: list[FigureJob] = []  # of a drawing process


def _prepare(drawing: Drawing) -> None:
    from reports.tables.leaderboard import with_numpy_types

    store = ResultsStore(drawing.results)
    _todo[:] = figure_jobs(store, with_numpy_types(store.table()), drawing.folder, drawing.pairs)


def _draw(number: int) -> PagePicture:
    return _todo[number].draw()


def figure_jobs(store: ResultsStore, table: pd.DataFrame, folder: Path, pairs: int | None) -> list[FigureJob]:
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
    if not scored_maps(maps).empty:
        found.append(FigureJob("missing", "error against missing surface", partial(_missing, maps, folder)))
    if not maps.empty:
        for dataset, rows in maps.groupby("dataset", sort=False):
            found.append(
                FigureJob("pck", f"PCK of {dataset}", partial(_pck, store, str(dataset), rows, folder))
            )
        for name in TITLES:
            if has_figure(name, store, maps):
                found.append(FigureJob("pck", TITLES[name][0], partial(_beyond, name, store, maps, folder)))
    for dataset, rows in stable[stable["source_threshold"].notna()].groupby("dataset", sort=False):
        found.append(
            FigureJob("stability", f"Eq. 18 of {dataset}", partial(_stability, str(dataset), rows, folder))
        )
    for dataset, views in scan_views(table).groupby("dataset", sort=False):
        found.append(
            FigureJob("scans", f"scans of {dataset}", partial(_scans, store, str(dataset), views, folder))
        )
    maker = PairMaker(store)
    for number, rows in enumerate(chosen_pairs(maps, pairs), start=1):
        first = rows.iloc[0]
        label = f"{first['dataset']}: {first['source_pose']} to {first['target_pose']}"
        found.append(FigureJob("pairs", label, partial(_pair, maker, rows, f"pair-{number:03d}", folder)))
    return found


def pair_groups(maps: pd.DataFrame) -> list[pd.DataFrame]:
    """Rows of the table by pair of scans, in the table's order."""
    keys = ["dataset", "regime", "seed", "source_scan", "target_scan"]
    return [rows for _, rows in maps.groupby(keys, sort=False)] if not maps.empty else []


def chosen_pairs(maps: pd.DataFrame, limit: int | None) -> list[pd.DataFrame]:
    """At most `limit` pairs: the one with the worst map, others spread evenly over data sets and regimes."""
    groups = pair_groups(maps)
    if limit is None or len(groups) <= limit:
        return groups
    worst = int(np.argmax([rows["geodesic_mean"].astype(float).fillna(-1).max() for rows in groups]))
    seen: dict[tuple[str, str], int] = {}
    rank = []
    for number in sorted(range(len(groups)), key=lambda number: number != worst):
        first = groups[number].iloc[0]
        kind = (str(first["dataset"]), str(first["regime"]))
        seen[kind] = seen.get(kind, -1) + 1
        rank.append((number != worst, seen[kind], number))
    return [groups[number] for number in sorted(number for *_, number in sorted(rank)[:limit])]


def scan_views(table: pd.DataFrame) -> pd.DataFrame:
    """Scans of the first seed at the most frequent views: dataset, pose, threshold, missing, views, key.

    Samples of a surface, which have no threshold, are no scans. Without the targets' views, as in a table of
    an earlier version, those of the sources are taken.
    """
    columns = ["dataset", "pose", "threshold", "missing", "views", "seed", "key"]
    parts = []
    for side in ("source", "target"):
        names = [f"{side}_{c}" for c in ("pose", "threshold", "missing")]
        wanted = ["dataset", *names, "views", "seed", f"{side}_scan"]
        if set(wanted) <= set(table.columns):
            part = table[wanted].set_axis(columns, axis=1)
            if side == "target" and "target_views" in table:
                part["views"] = table["target_views"].fillna(table["views"])
            parts.append(part)
    scans = pd.concat(parts).dropna(subset=["threshold", "key", "missing"]).drop_duplicates("key")
    scans = scans[scans["views"] != SURFACE]
    if scans.empty:
        return scans
    usual = scans.groupby("dataset")["views"].agg(lambda views: views.mode().iloc[0])
    scans = scans[(scans["views"] == scans["dataset"].map(usual)) & (scans["seed"] == scans["seed"].min())]
    return scans.drop_duplicates(["dataset", "pose", "threshold"])


def evenly_picked(values: list[float], count: int) -> list[float]:
    """At most `count` of the sorted values, evenly spread, with the first and the last."""
    ordered = sorted(values)
    if len(ordered) <= count:
        return ordered
    return [ordered[round(i)] for i in np.linspace(0, len(ordered) - 1, count)]


def _missing(maps: pd.DataFrame, folder: Path) -> PagePicture:
    about = "One dot per map; lines join the medians of groups of equal size."
    return _saved(
        error_against_missing(maps), folder, "error-missing", "Error against missing surface", about
    )


def _pck(store: ResultsStore, dataset: str, maps: pd.DataFrame, folder: Path) -> PagePicture:
    curves: dict[str, dict[str, np.ndarray]] = {}
    for (regime, method), curve in mean_curves(store, maps).items():
        curves.setdefault(regime, {})[method] = curve
    about = "Share of points whose match lies within a radius, mean over maps."
    figure = pck_curves(curves, 100 * CURVE)
    return _saved(figure, folder, f"pck-{_file_name(dataset)}", f"PCK, {dataset}", about)


def _beyond(name: str, store: ResultsStore, maps: pd.DataFrame, folder: Path) -> PagePicture:
    return _saved(MAKERS[name](store, maps).figure, folder, FILES[name], *TITLES[name])


def _stability(dataset: str, rows: pd.DataFrame, folder: Path) -> PagePicture:
    about = "A line per pose; in the strip below, the missing surface, mean and range over poses."
    return _saved(diffusion_error_curves(rows), folder, f"stability-{_file_name(dataset)}", dataset, about)


def _scans(store: ResultsStore, dataset: str, views: pd.DataFrame, folder: Path) -> PagePicture:
    thresholds = evenly_picked(list(views["threshold"].unique()), THRESHOLDS)
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
    what = f"{views['views'].iloc[0]} views; what shows through a hole is the inside, in grey."
    return _saved(scan_series(rows, up), folder, f"scans-{_file_name(dataset)}", dataset, what)


def _pair(maker: PairMaker, rows: pd.DataFrame, name: str, folder: Path) -> PagePicture:
    first, pair = rows.iloc[0], maker.read(rows)
    title = f"{first['dataset']}: {first['source_pose']} → {first['target_pose']}"
    seed = f", seed {first['seed']}" if int(first["seed"]) else ""
    group = f"{first['dataset']}, {first['regime']}"
    found = _saved(
        method_comparison(pair_picture(pair)), folder, name, title, f"{first['regime']}{seed}.", group
    )
    errors = [float(error) for each in pair.maps if pd.notna(error := each.row["geodesic_mean"])]
    return replace(
        found,
        error=min(errors, default=float("nan")),
        pair=pair_key(first),
        view=packed(view_of_pair(pair, f"{title}, {first['regime']}{seed}")),
    )


def _saved(figure: Figure, folder: Path, name: str, title: str, caption: str, group: str = "") -> PagePicture:
    save(figure, folder, name)
    return PagePicture(name, title, caption, float(figure.get_figwidth()), group)


def _file_name(text: str) -> str:
    """A name that every file system takes; a text that is none by itself gets a hash, so that all differ."""
    plain = "".join(c if c.isascii() and (c.isalnum() or c in "-_") else "-" for c in text.lower())[:60]
    return plain if plain == text else f"{plain}-{digest(text)[:8]}"

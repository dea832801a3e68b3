"""From the stored maps of a pair of scans to what `method_comparison` draws."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen import Collection
from evaluation.metrics.correspondence import SurfacePoints, correspondence_error
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.results.store import ResultsStore
from medial import Diffusion, Matching
from reports.figures.cloud_drawing import ERROR_CAP, DrawnCloud, carried_colors, position_colors
from reports.figures.method_comparison import MethodPanel, PairPicture
from reports.figures.style import ABSENT
from reports.method_order import order_methods
from scanner_sim import Scan

COUNTERPART = 0.05
"""A target point has a counterpart if a source point is this near on the rest pose, in sqrt(area)."""


@dataclass(frozen=True)
class PlacedScan:
    """A scan and where its points lie on the rest pose, (n, 3)."""

    scan: Scan
    rest: NDArray[np.float64]

    @property
    def surface(self) -> SurfacePoints:
        """Its points on the mesh."""
        return SurfacePoints(self.scan.face_ids, self.scan.barycentrics)


@dataclass(frozen=True)
class StoredMap:
    """A map of a results folder: its row of the table, what was found, errors x 100 / sqrt(area), (n,)."""

    row: "pd.Series[Any]"
    found: Matching
    errors: NDArray[np.float64]


@dataclass(frozen=True)
class StoredPair:
    """A pair of scans of a results folder, with the maps of all methods in the order of the tables.

    Attributes
    ----------
    source, target : PlacedScan
    colors : (n, 3) float64
        Of the source points.
    diffusions : tuple of Diffusion or None
        The medial operators of both, where a method used them.
    maps : tuple of StoredMap
    unit : float
        sqrt(area) of the rest pose.
    """

    source: PlacedScan
    target: PlacedScan
    colors: NDArray[np.float64]
    diffusions: tuple[Diffusion | None, Diffusion | None]
    maps: tuple[StoredMap, ...]
    unit: float

    @property
    def up(self) -> int:
        """Axis that points upwards."""
        return "xyz".index(self.source.scan.config.up)


class PairMaker:
    """Reads stored pairs of scans; keeps the distances of the last data set."""

    def __init__(self, store: ResultsStore) -> None:
        self.store = store
        self._collection = lru_cache(maxsize=1)(store.collection)
        self._distance = lru_cache(maxsize=1)(self._measure)

    def _measure(self, dataset: str) -> SurfaceDistance:
        return SurfaceDistance(self._collection(dataset).reference)

    def read(self, rows: pd.DataFrame) -> StoredPair:
        """All that is stored of one pair of scans.

        Parameters
        ----------
        rows
            Rows of the table with one pair of scans and one method each.
        """
        first = rows.iloc[0]
        dataset = str(first["dataset"])
        collection = self._collection(dataset)
        source, target = (self._side(collection, first[f"{name}_scan"]) for name in ("source", "target"))
        diffusions = self._diffusions(rows)
        by_method = {str(row["method"]): row for _, row in rows.iterrows()}
        return StoredPair(
            source=source,
            target=target,
            colors=source_colors(source, diffusions[0]),
            diffusions=diffusions,
            maps=tuple(
                self._map(by_method[method], dataset, source, target) for method in order_methods(by_method)
            ),
            unit=float(np.sqrt(collection.reference.area)),
        )

    def _side(self, collection: Collection, key: str) -> PlacedScan:
        scan = self.store.scan(key)
        return PlacedScan(scan, collection.reference.at(scan.face_ids, scan.barycentrics))

    def _diffusions(self, rows: pd.DataFrame) -> tuple[Diffusion | None, Diffusion | None]:
        """The medial operators of source and target, if a method used them."""
        for key in rows["map_key"]:
            inputs = (self.store.record("map", str(key)) or {}).get("inputs", {})
            source, target = (inputs.get(f"{side}_medial") for side in ("source", "target"))
            if source is not None:
                there = None if target is None else self.store.operator(target)
                return self.store.operator(source), there
        return None, None

    def _map(self, row: "pd.Series[Any]", dataset: str, source: PlacedScan, target: PlacedScan) -> StoredMap:
        found = self.store.matching(str(row["map_key"]))
        return StoredMap(row, found, 100 * self._errors(dataset, source, target, found.source_to_target))

    def _errors(
        self, dataset: str, source: PlacedScan, target: PlacedScan, image: NDArray[np.integer]
    ) -> NDArray[np.float64]:
        """Geodesic errors in sqrt(area), (n,); straight ones where those pass the end of the colours."""
        area = self._collection(dataset).reference.area
        errors = np.linalg.norm(source.rest - target.rest[image], axis=1) / np.sqrt(area)
        errors[image < 0] = np.nan
        near = np.flatnonzero(errors < ERROR_CAP / 100)  # a geodesic is never shorter
        errors[near] = correspondence_error(
            self._distance(dataset), source.surface[near], target.surface, image[near], area
        )
        return errors


def pair_picture(pair: StoredPair) -> PairPicture:
    """What is drawn of a pair of scans."""
    return PairPicture(
        source=_cloud(pair.maps[0].row, "source", pair.source),
        target=_cloud(pair.maps[0].row, "target", pair.target),
        source_colors=pair.colors,
        truth_colors=true_colors(pair.source.rest, pair.target.rest, pair.colors, pair.unit),
        panels=tuple(
            MethodPanel(
                title=str(each.row["method"]),
                note=error_note(each.row),
                target_colors=carried_colors(
                    each.found.source_to_target, pair.colors, pair.target.scan.points
                ),
                errors=each.errors,
                landmarks=each.found.landmarks,
            )
            for each in pair.maps
        ),
        up=pair.up,
    )


def source_colors(source: PlacedScan, diffusion: Diffusion | None) -> NDArray[np.float64]:
    """Colours of the medial centres (Eq. 9) as in the paper; of the points if no method built them."""
    places = source.scan.points if diffusion is None else diffusion.centers
    low, high = np.quantile(places, [0.01, 0.99], axis=0)
    return position_colors(places, low, high)


def error_note(row: "pd.Series[Any] | Mapping[str, Any]") -> str:
    """A map's errors in a few words."""
    if pd.isna(row["geodesic_mean"]):
        return "error unknown"
    words = f"mean {row['geodesic_mean']:.1f}"
    median = row.get("geodesic_median")
    words += "" if pd.isna(median) else f", median {median:.1f}"
    return f"{words}, flipped" if row.get("flipped") is True or row.get("flipped") == 1 else words


def scan_words(row: "pd.Series[Any]", side: str, scan: Scan) -> str:
    """How a scan was made and what it lacks, in a few words.

    Parameters
    ----------
    row
        Of the results table.
    side
        ``"source"`` or ``"target"``.
    scan
        The cloud; one that was sampled has no threshold, whatever the experiment's default.
    """
    threshold, missing = row.get(f"{side}_threshold"), row.get(f"{side}_missing")
    words = ["sampled"] if (scan.view_ids < 0).all() else [f"τ {threshold:g}"] if pd.notna(threshold) else []
    return ", ".join([*words, *([f"{100 * missing:.0f} % missing"] if pd.notna(missing) else [])])


def _cloud(row: "pd.Series[Any]", side: str, cloud: PlacedScan) -> DrawnCloud:
    caption = ", ".join(filter(None, [str(row[f"{side}_pose"]), scan_words(row, side, cloud.scan)]))
    return DrawnCloud(cloud.scan.points, cloud.scan.normals, caption)


def true_colors(
    source: NDArray[np.float64], target: NDArray[np.float64], colors: NDArray[np.float64], unit: float
) -> NDArray[np.float64]:
    """Colours of a perfect map: of the source point that lies nearest on the rest pose, where one is near.

    Parameters
    ----------
    source : (n, 3), target : (m, 3)
        Positions on the rest pose.
    colors : (n, 3)
        Of the source.
    unit
        sqrt(area) of the rest pose.

    Returns
    -------
    (m, 3) float64
    """
    gap, nearest = cKDTree(source).query(target)
    return np.where((gap <= COUNTERPART * unit)[:, None], colors[nearest], to_rgb(ABSENT))

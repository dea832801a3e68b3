"""Scans of the page: each with all its thresholds, so that a slider goes through them."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import pandas as pd

from evaluation.results.store import ResultsStore
from reports.viewer.packing import packed
from reports.viewer.views import view_of_scan
from scanner_sim import Scan

POSES = 3
"""Scans of each data set."""


@dataclass(frozen=True)
class ScanChoice:
    """A scan that readers may pick.

    Attributes
    ----------
    name : str
        Of the scene, and of the file that may hold it.
    title : str
    view : str
        Packed scene (`reports.viewer.packing`).
    """

    name: str
    title: str
    view: str


def scan_choices(store: ResultsStore, views: pd.DataFrame) -> Iterator[ScanChoice]:
    """The first poses of each data set, those with most thresholds first.

    Parameters
    ----------
    store
    views
        Of `reports.page.pictures.scan_views`: dataset, pose, threshold, key.
    """
    number = 0
    for dataset, rows in views.groupby("dataset", sort=False):
        counts = rows.groupby("pose", sort=False)["threshold"].nunique()
        for pose in counts.sort_values(ascending=False, kind="stable").index[:POSES]:
            number += 1
            own = rows[rows["pose"] == pose].sort_values("threshold")
            scan = joined([store.scan(str(key)) for key in own["key"]])
            title = f"{dataset}: {pose}, {views_text(own['views'].iloc[0])}"
            yield ScanChoice(f"scan-{number:02d}", title, packed(view_of_scan(scan, title)))


def views_text(views: str) -> str:
    """``6`` or ``front:2`` in words."""
    return f"{views} views" if str(views).isdigit() else f"views {views}"


def joined(scans: list[Scan]) -> Scan:
    """Scans of one pose at several thresholds as one: each point once, by view and pixel.

    Stored scans are thinned out after thresholding, so that each has points that the others lack.
    """
    places = np.concatenate([np.column_stack([s.view_ids, s.pixels]) for s in scans])
    _, first = np.unique(places, axis=0, return_index=True)
    first.sort()
    whole = ("poses", "scale", "shape_name", "config", "seed", "variant")
    per_point = [field.name for field in fields(Scan) if field.name not in whole]
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(scan, name) for scan in scans])[first] for name in per_point
    }
    return replace(scans[0], **arrays)

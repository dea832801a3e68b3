"""Scenes of the pairs of a results folder, with the maps of all methods."""

import numpy as np
from scipy.spatial import cKDTree

from reports.figures.pair_pictures import COUNTERPART, PlacedScan, StoredPair, error_note, scan_words
from reports.viewer.scene import Scene, ViewCloud, ViewField, ViewMap
from reports.viewer.views import signatures

ERROR_TOP = 10.0
"""Error at the end of the fixed scale: ten times what a good map has, so that it is not all one colour."""


def view_of_pair(pair: StoredPair, title: str) -> Scene:
    """The scene of a pair of scans with at least one map."""
    fields = signatures([each for each in pair.diffusions if each is not None])
    first = pair.maps[0].row
    clouds = []
    for side, placed, diffusion in zip(
        ("source", "target"), (pair.source, pair.target), pair.diffusions, strict=True
    ):
        extra: list[ViewField] = [] if diffusion is None else [fields[id(diffusion)]]
        clouds.append(
            ViewCloud(
                name=str(first[f"{side}_pose"]),
                points=placed.scan.points,
                normals=placed.scan.normals,
                caption=scan_words(first, side, placed.scan),
                colors=pair.colors if side == "source" else None,
                color_label="medial centre (Eq. 9)" if diffusion is not None else "place",
                centers=None if diffusion is None else diffusion.centers,
                fields=(*_counterparts(side, pair), *extra),
            )
        )
    maps = [
        ViewMap(
            label=str(each.row["method"]),
            image=each.found.source_to_target,
            note=error_note(each.row),
            confidence=each.found.confidence,
            errors=each.errors,
            landmarks=each.found.landmarks,
        )
        for each in pair.maps
    ]
    return Scene(
        title=title,
        clouds=tuple(clouds),
        maps=tuple(maps),
        up=pair.up,
        truth=_nearest(pair.source, pair.target, pair.unit),
        error_top=ERROR_TOP,
    )


def _nearest(source: PlacedScan, target: PlacedScan, unit: float) -> np.ndarray:
    """Target point nearest to the true place of each source point; -1 where none is near."""
    gap, nearest = cKDTree(target.rest).query(source.rest)
    return np.where(gap <= COUNTERPART * unit, nearest, -1)


def _counterparts(side: str, pair: StoredPair) -> tuple[ViewField, ...]:
    """Distance of each point from what the other scan has of the body: where nothing was scanned."""
    here, there = (pair.source, pair.target) if side == "source" else (pair.target, pair.source)
    gap = cKDTree(there.rest).query(here.rest)[0]
    return (
        ViewField(
            "gap",
            "distance to what the other scan has, × 100 / √area",
            100 * gap / pair.unit,
            0.0,
            100 * COUNTERPART * 2,
        ),
    )

"""One map without ground truth: colours that travel from a cloud to another, landmarks, confidence."""

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from reports.figures.cloud_drawing import (
    DrawnCloud,
    caption,
    carried_colors,
    mark_landmarks,
    place_cloud,
    position_colors,
)
from reports.figures.cloud_sheet import add_key
from reports.figures.pair_cameras import pair_cameras
from reports.figures.style import CLOUD_INCHES, blank, new_figure, styled

CONFIDENCE = LinearSegmentedColormap.from_list("confidence", ["#fff3bf", "#7fcdbb", "#2c7fb8", "#081d58"])
"""Yellow where a map is not sure of itself, dark blue where it is: neither looks like a gap."""

HEADING_HEIGHT = 0.25
"""Inches that a heading takes."""


@styled
def dense_map(
    source: DrawnCloud,
    target: DrawnCloud,
    source_to_target: NDArray[np.integer],
    confidence: NDArray[np.float64],
    landmarks: NDArray[np.integer],
    height: int = 480,
    up: int = 1,
    heading: str = "",
) -> Figure:
    """Source, target with the colours that arrive, and the confidence on the source; see `pair_cameras`.

    Parameters
    ----------
    source, target
    source_to_target : (n_source,)
        -1 for no match.
    confidence : (n_source,) float64
        In [0, 1].
    landmarks : (L, 2)
        Source and target point ids.
    height
        Pixels of the taller cloud.
    up
        Axis that points upwards.
    heading
        Of the whole picture, at its top; none where it is empty.
    """
    low, high = np.quantile(source.points, [0.01, 0.99], axis=0)
    colors = position_colors(source.points, low, high)
    arrived = carried_colors(source_to_target, colors, target.points)
    cameras = pair_cameras(source, target, up, height)
    here, there = cameras.source, cameras.target
    wide = 3 * max(CLOUD_INCHES * here.width / height, 1.8) + 0.6
    figure, grid = new_figure(1, 3, wide, CLOUD_INCHES + 0.85 + (HEADING_HEIGHT if heading else 0.0))
    if heading:
        figure.suptitle(heading, x=0.01, ha="left", fontsize=9.5)
    sure = CONFIDENCE(confidence)[:, :3]
    for axes, cloud, shown, camera, title, side in (
        (grid[0, 0], source, colors, here, "source", 0),
        (grid[0, 1], target, arrived, there, f"target{cameras.words}", 1),
        (grid[0, 2], source, sure, here, "confidence", None),
    ):
        blank(axes)
        place_cloud(axes, cloud.points, cloud.normals, shown, camera)
        caption(axes, title, cloud.caption if side is not None else "on the source")
        if side is not None and len(landmarks):
            ids = landmarks[:, side]
            mark_landmarks(axes, cloud.points[ids], cloud.normals[ids], camera)
    scale = mpl.cm.ScalarMappable(mpl.colors.Normalize(0, 1), CONFIDENCE)
    bar = figure.colorbar(scale, ax=grid[0, 2], shrink=0.7, aspect=24, pad=0.02, panchor=False)
    bar.outline.set_visible(False)
    add_key(figure)
    return figure

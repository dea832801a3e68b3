"""What is written of the skeleton of a cloud beside its file: the nodes of all points, a picture, a page."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from medial.skeletons import CurveSkeleton
from medial.skeletons.skeleton_paths import SkeletonPaths
from reports.cli.cloud_files import ThinnedCloud
from reports.figures.cloud_drawing import position_colors
from reports.figures.skeleton_drawing import skeleton_picture
from reports.figures.style import save
from reports.viewer.scene import Scene, ViewCloud
from reports.viewer.view_page import write_view
from scanner_sim import Scan


def carried(found: CurveSkeleton, cloud: ThinnedCloud) -> CurveSkeleton:
    """The skeleton of the used points as that of all given points, which follow their nearest one."""
    return replace(found, node_of_point=found.node_of_point[cloud.nearest])


def draw_skeleton(picture: Path, scan: Scan, name: str, found: CurveSkeleton) -> None:
    """Draw a skeleton over its cloud into a file."""
    up = "xyz".index(scan.config.up)
    figure = skeleton_picture(scan.points, scan.normals, found, name, up)
    save(figure, picture.parent, picture.stem, formats=(picture.suffix.lower(),))


def show_skeleton(view: Path, scan: Scan, name: str, found: CurveSkeleton) -> None:
    """Write a page that shows a cloud, and its points moved to their places on the skeleton."""
    places = on_skeleton(found, scan.points)
    shown = ViewCloud(
        name=name,
        points=scan.points,
        normals=scan.normals,
        caption=f"{len(scan):,} points, {len(found)} nodes",
        colors=position_colors(places, *np.quantile(places, [0.01, 0.99], axis=0)),
        color_label="place on the skeleton",
        centers=places,
    )
    write_view(Scene(title=f"skeleton of {name}", clouds=(shown,), up="xyz".index(scan.config.up)), view)


def on_skeleton(found: CurveSkeleton, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The place of every point on the skeleton, (n, 3); the point itself where there is none."""
    if len(found.edges):
        paths = SkeletonPaths.of(found, points)
        places = paths.places[paths.of_point]
    elif len(found):
        places = found.nodes[np.maximum(found.node_of_point, 0)]
    else:
        return points
    return np.where((found.node_of_point >= 0)[:, None], places, points)

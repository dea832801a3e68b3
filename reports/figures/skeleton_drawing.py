"""Curve skeletons drawn over their clouds."""

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from medial.skeletons import CurveSkeleton
from reports.figures.cloud_sheet import CloudPanel, cloud_sheet
from reports.figures.point_renderer import Camera, best_azimuth, look_from
from reports.figures.style import INK, styled

PALE = "#e6e2dd"
"""Of the cloud under a skeleton."""
TIP, JOINT, CURVE = "#d55e00", "#0072b2", INK
_MARKS = {"tip": (TIP, "o", 4.6), "joint": (JOINT, "s", 4.4), "alone": (TIP, "D", 4.2)}
INCHES = 4.5
"""Larger extent of the cloud in a picture of its own."""
SKELETON_KEY = (
    Line2D([], [], color=CURVE, lw=1.6, label="curve skeleton"),
    Line2D([], [], marker="o", ls="", mfc=TIP, mec="white", ms=6, label="tip"),
    Line2D([], [], marker="s", ls="", mfc=JOINT, mec="white", ms=5.5, label="joint"),
)
"""What the marks mean."""


@styled
def skeleton_picture(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    skeleton: CurveSkeleton,
    name: str,
    up: int = 1,
) -> Figure:
    """A cloud with its skeleton over it.

    Parameters
    ----------
    points, normals : (n, 3)
    skeleton
    name
        Of the cloud.
    up
        Axis that points upwards: 0, 1 or 2.
    """
    rotation = look_from(best_azimuth(points, up), up=up)
    seen = points @ rotation[:2].T
    size = float(np.ptp(seen, axis=0).max())
    panel = skeleton_panel(points, normals, skeleton, rotation, size, title=name)
    return cloud_sheet([[panel]], key=SKELETON_KEY, inches=INCHES).figure


def skeleton_panel(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    skeleton: CurveSkeleton,
    rotation: NDArray[np.float64],
    size: float,
    title: str = "",
    note: str = "",
) -> CloudPanel:
    """A pale cloud with its skeleton over it.

    Parameters
    ----------
    points, normals : (n, 3)
    skeleton
        In the frame of the points.
    rotation : (3, 3)
        Of the camera.
    size
        Diagonal of the body at rest.
    title, note
        Head, and small print: by default what the skeleton has.
    """
    return CloudPanel(
        points,
        normals,
        np.tile(to_rgb(PALE), (len(points), 1)),
        rotation,
        size,
        title=title,
        note=note or in_words(skeleton),
        overlay=partial(_draw, skeleton),
    )


def in_words(skeleton: CurveSkeleton) -> str:
    """Tips, joints and parts of a skeleton, or that it has no curve."""
    if not len(skeleton.edges):
        return "no curve"
    tips, joints = (int((skeleton.kinds == kind).sum()) for kind in ("tip", "joint"))
    parts = len(np.unique(skeleton.components))
    counts = [(tips, "tip"), (joints, "joint"), (parts, "part")]
    return ", ".join(f"{count} {word}{'' if count == 1 else 's'}" for count, word in counts)


def _draw(skeleton: CurveSkeleton, axes: Axes, camera: Camera) -> None:
    """Edges with a white rim, so that they are seen on any ground, then tips and joints."""
    seen = camera.project(skeleton.nodes)[:, :2].reshape(-1, 2)
    for width, color in ((3.2, "white"), (1.6, CURVE)):
        lines = LineCollection(list(seen[skeleton.edges]), colors=color, linewidths=width, capstyle="round")
        axes.add_collection(lines, autolim=False)
    for kind, (color, marker, width) in _MARKS.items():
        at = seen[skeleton.kinds == kind]
        axes.plot(*at.T, marker, ms=width, mfc=color, mec="white", mew=0.6, ls="", zorder=4, clip_on=False)

"""Fig. 3 of the paper on a real cloud: how the dual area of one point is found (Eq. 10 and what follows it).

Left, the points that belong to a similar medial region; in the middle, their projection to the point's medial
ball, which is made where the point is no corner of their convex hull; right, the hull with the triangles at
the point, a third of whose area is its dual area.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, cKDTree

from datasets_gen.records import InputError
from medial.areas.dual_area import EPSILON, JOINED
from medial.areas.equations import incident_area, medial_neighbourhood
from reports.figures.cloud_drawing import place_cloud
from reports.figures.cloud_sheet import EDGE, LINE, PIXELS, CloudPanel, CloudSheet, note_lines, put_note
from reports.figures.figure_request import FigureRequest, MadeFigure, ScannedPose, front_view
from reports.figures.style import INK, QUIET, blank, styled

POSE = "rest"
THRESHOLD = 0.3
POINTS = 5000
MEMBERS = 24
"""Points of the neighbourhood from which the construction is clear."""
OWN, NEIGHBOUR, BALL, PALE = "#d55e00", "#0072b2", "#8c8c8c", "#cfd6dc"
SIDE = 2.5
TRIED = 150
"""Points among which the clearest example is picked."""


@dataclass(frozen=True)
class DualArea:
    """The construction at one point.

    Attributes
    ----------
    point : int
    members : (m,) int64
        B_i with the points that join it, `point` among them.
    corners : (m, 3) float64
        What the hull is of: the members, or their projections to the medial ball.
    projected : bool
        Whether the point is no corner of the hull of the members themselves.
    triangles : (f, 3) int
        Of the hull, as rows of `corners`.
    area : float
        Dual area, in squared units, before it is calibrated.
    """

    point: int
    members: NDArray[np.int64]
    corners: NDArray[np.float64]
    projected: bool
    triangles: NDArray[np.int32]
    area: float

    @property
    def own(self) -> int:
        """Row of the point among the corners."""
        return int(np.flatnonzero(self.members == self.point)[0])

    @property
    def incident(self) -> NDArray[np.bool_]:
        """Triangles at the point."""
        return (self.triangles == self.own).any(axis=1)


def dual_area_at(each: ScannedPose, i: int) -> DualArea | None:
    """The construction at a point, as the operator does it: the `JOINED` nearest points join B_i.

    Parameters
    ----------
    each
    i

    Returns
    -------
    DualArea or None
        None if neither hull has the point as a corner.
    """
    points, found = each.scan.points, each.diffusion
    near = cKDTree(points).query(points[i], k=JOINED + 1)[1]
    members = np.union1d(medial_neighbourhood(i, found.centers, EPSILON * each.spacing), near)
    own = int(np.flatnonzero(members == i)[0])
    offsets = points[members] - found.centers[i]
    on_ball = found.centers[i] + found.radii[i] * offsets / np.linalg.norm(offsets, axis=1, keepdims=True)
    for projected, corners in ((False, points[members]), (True, on_ball)):
        area = incident_area(corners, own)
        if np.isfinite(area):
            triangles = ConvexHull(corners).simplices
            return DualArea(i, members, corners, projected, triangles, area / 3)
    return None


@styled
def dual_area_construction(request: FigureRequest) -> MadeFigure:
    """Show the dual area of a point whose neighbourhood has to be projected to its ball.

    Parameters
    ----------
    request

    Raises
    ------
    InputError
        If no point of the scan has a neighbourhood that can be shown.
    """
    body = request.body("human")
    shape = request.shapes(body, (POSE,), 1)[0]
    threshold, points = request.threshold(THRESHOLD), request.count(POINTS)
    each = ScannedPose.of(request, shape, threshold, 10, points)
    request.tell("dual areas")
    found = _clear_example(each, request.seed)
    note = (
        f"{shape.name}, 10 views, threshold {threshold:g}, {each.note}, seed {request.seed}. a: the points "
        f"B whose medial points lie within {EPSILON:g} sampling distances of that of p (Eq. 10), with the "
        f"{JOINED} points nearest to p, and the medial ball of p (Eq. 9). b: "
        + (
            "p is no corner of their convex hull, so that all are moved to the ball, along the lines. "
            if found.projected
            else "p is a corner of their convex hull, so that none has to be moved to the ball. "
        )
        + f"c: the hull; a third of the triangles at p is its dual area, {found.area:.3g} squared units."
    )
    settings = {"shape": shape.name, "threshold": threshold, "points": points, "seed": request.seed}
    return MadeFigure(
        _drawn(body.reference.diagonal, front_view(body), each, found, note), _table(each, found), settings
    )


def _clear_example(each: ScannedPose, seed: int) -> DualArea:
    """A point with some `MEMBERS` neighbours, projected if there is one, on a ball of middling size."""
    radii = each.diffusion.radii
    low, high = np.quantile(radii, [0.5, 0.95])
    order = np.random.default_rng(seed).permutation(np.flatnonzero((radii >= low) & (radii <= high)))[:TRIED]
    best, distance = None, np.inf
    for i in order:
        found = dual_area_at(each, int(i))
        if found is None:
            continue
        spread = np.linalg.norm(each.scan.points[found.members] - each.scan.points[i], axis=1).max()
        off = abs(len(found.members) - MEMBERS) / MEMBERS + 2 * (not found.projected)
        off += max(1.5 - spread / radii[i], 0)
        if off < distance:
            best, distance = found, off
    if best is None:
        raise InputError("no point of the scan has a dual area; give more points or another pose")
    return best


def _table(each: ScannedPose, found: DualArea) -> pd.DataFrame:
    """A row per member: its place, where it is projected to, and the area of its triangles at the point."""
    a, b, c = (found.corners[found.triangles[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    table = pd.DataFrame({"point": found.members, "is_p": found.members == found.point})
    for name, places in (("", each.scan.points[found.members]), ("hull_", found.corners)):
        table = table.assign(**{f"{name}{axis}": places[:, k] for k, axis in enumerate("xyz")})
    corner = [areas[found.incident & (found.triangles == k).any(axis=1)].sum() for k in range(len(table))]
    return table.assign(triangles_at_p=corner, projected=found.projected, dual_area_of_p=found.area)


def _drawn(
    size: float, rotation: NDArray[np.float64], each: ScannedPose, found: DualArea, note: str
) -> Figure:
    """Where it is, and the three steps through one camera that looks at p from its side."""
    small = CloudPanel(
        each.scan.points, each.scan.normals, np.tile([0.75, 0.79, 0.83], (len(each.scan), 1)), rotation, size
    )
    camera = small.camera(SIDE)
    aside = camera.width / PIXELS
    width = aside + 3 * SIDE + 2 * EDGE + 0.6
    lines = note_lines(note, width)
    sheet = CloudSheet(width, SIDE + 0.62 + LINE * len(lines))
    overview = sheet.axes(EDGE, 0.42, aside, camera.height / PIXELS)
    place_cloud(overview, small.points, small.normals, small.colors, camera)
    column, row, _ = camera.project(each.scan.points[found.point][None])[0]
    overview.plot(column, row, "o", color=OWN, ms=6, mec="white", mew=0.8)
    overview.add_patch(
        Circle((column, row), each.diffusion.radii[found.point] * camera.scale, fill=False, ec=INK)
    )
    overview.set_title("where p is")
    titles = ("a  neighbourhood B", "b  moved to the ball", "c  hull, triangles at p")
    steps = (_neighbourhood, _projection, _hull)
    for number, (title, step) in enumerate(zip(titles, steps, strict=True)):
        axes = sheet.axes(EDGE + aside + 0.25 + number * (SIDE + 0.1), 0.42, SIDE, SIDE)
        blank(axes)
        flat = _Flat.of(each, found)
        step(axes, flat, each, found)
        axes.set_xlim(-flat.reach, flat.reach)
        axes.set_ylim(-flat.reach, flat.reach)
        axes.set_title(title)
    put_note(sheet, lines, SIDE + 0.52)
    return sheet.figure


@dataclass(frozen=True)
class _Flat:
    """A view of the neighbourhood: right, up and towards the viewer, with the medial point in the middle."""

    frame: NDArray[np.float64]
    center: NDArray[np.float64]
    reach: float

    @classmethod
    def of(cls, each: ScannedPose, found: DualArea) -> "_Flat":
        center = each.diffusion.centers[found.point]
        out = each.scan.points[found.point] - center
        out /= np.linalg.norm(out)
        side = np.linalg.svd(out[None])[2][1]
        towards = 0.72 * out + 0.55 * side + 0.42 * np.cross(out, side)
        towards /= np.linalg.norm(towards)
        right = np.cross(side, towards)
        right /= np.linalg.norm(right)
        frame = np.array([right, np.cross(towards, right), towards])
        offsets = np.concatenate([each.scan.points[found.members], found.corners]) - center
        return cls(
            frame,
            center,
            1.08 * float(max(np.abs(offsets @ frame[:2].T).max(), each.diffusion.radii[found.point])),
        )

    def __call__(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Right, up and depth of places, (n, 3)."""
        return np.asarray((places - self.center) @ self.frame.T)


def _dots(axes: Axes, places: NDArray[np.float64], own: int, color: str = NEIGHBOUR) -> None:
    for depth, some in ((0.4, places[:, 2] < 0), (1.0, places[:, 2] >= 0)):
        axes.plot(*places[some, :2].T, "o", color=color, ms=4.5, mec="white", mew=0.5, alpha=depth)
    axes.plot(*places[own, :2], "o", color=OWN, ms=6.5, mec="white", mew=0.7, zorder=6)
    axes.annotate(
        "p",
        (places[own, 0], places[own, 1]),
        xytext=(7, 5),
        textcoords="offset points",
        color=OWN,
        fontweight="bold",
    )


def _ball(axes: Axes, each: ScannedPose, found: DualArea) -> None:
    axes.add_patch(Circle((0, 0), each.diffusion.radii[found.point], fc=PALE, ec=BALL, lw=1, alpha=0.35))
    axes.plot(0, 0, "x", color=INK, ms=5, mew=1.3)


def _neighbourhood(axes: Axes, flat: _Flat, each: ScannedPose, found: DualArea) -> None:
    _ball(axes, each, found)
    places = flat(each.scan.points)
    around = np.flatnonzero(
        (np.abs(places[:, :2]) < flat.reach).all(axis=1) & (np.abs(places[:, 2]) < 1.5 * flat.reach)
    )
    axes.plot(*places[around, :2].T, ".", color=QUIET, ms=2.5, mew=0, alpha=0.6, rasterized=True)
    _dots(axes, places[found.members], found.own)


def _projection(axes: Axes, flat: _Flat, each: ScannedPose, found: DualArea) -> None:
    _ball(axes, each, found)
    before, after = flat(each.scan.points[found.members]), flat(found.corners)
    axes.add_collection(
        LineCollection(list(np.stack([before[:, :2], after[:, :2]], axis=1)), colors=QUIET, lw=0.9)
    )
    axes.plot(*before[:, :2].T, "o", mfc="white", mec=NEIGHBOUR, ms=3.5, mew=0.8)
    _dots(axes, after, found.own)


def _hull(axes: Axes, flat: _Flat, each: ScannedPose, found: DualArea) -> None:
    places = flat(found.corners)
    depth = places[found.triangles, 2].mean(axis=1)
    for k in np.argsort(depth):
        at_p = bool(found.incident[k])
        face = PolyCollection(
            [places[found.triangles[k], :2]],
            facecolors=OWN if at_p else PALE,
            edgecolors="white" if at_p else BALL,
            linewidths=0.9 if at_p else 0.5,
            alpha=0.75 if at_p else 0.35,
        )
        axes.add_collection(face)
    _dots(axes, places, found.own)

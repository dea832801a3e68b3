"""Fig. 7 of the paper: intrinsic symmetries, as lines between the medial centres of points and their images.

Three bodies; of one, a part of a limb was taken out of the scan, so that its end is a component of its own.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from datasets_gen import Collection, InputError
from datasets_gen.points.farthest import farthest_points
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.metrics.limbs import find_limbs
from medial import Matching, intrinsic_symmetry
from reports.figures.cloud_drawing import position_colors
from reports.figures.cloud_sheet import INNER, CloudPanel, cloud_sheet
from reports.figures.figure_request import UP, FigureRequest, MadeFigure, ScannedPose, cloud_table
from reports.figures.matched_pair import mirrored_mean
from reports.figures.point_renderer import Camera, look_from
from reports.figures.style import styled
from scanner_sim import Scan, coverage

BODIES = (("human", "walk"), ("quadruped", "trot"), ("bird", "walk"))
CUT_BODY = "human"
"""Of the figure's own bodies, the one of which a limb is cut."""
THRESHOLD, VIEWS = 0.6, 6
POINTS = 3000
LINES = 45
"""Regions that are joined to their images."""
SURE = 0.3
"""Confidence from which a region is joined."""
BAND = (0.33, 0.4)
"""What is taken out: distances from the tip of the limb, in sqrt(area)."""
VIEWPOINT = (38.0, 16.0)
"""Azimuth from the front and elevation, degrees: lines from left to right must not be seen end on."""
PARTS = 4.0
"""Gap between components, in sampling distances."""


@dataclass(frozen=True)
class SymmetricBody:
    """A scanned body and its symmetry.

    Attributes
    ----------
    body : Collection
    each : ScannedPose
    found : Matching
    cut : str
        What was taken out, in words; empty if nothing.
    """

    body: Collection
    each: ScannedPose
    found: Matching
    cut: str = ""

    @classmethod
    def of(cls, request: FigureRequest, body: Collection, pose: str, cut: bool) -> "SymmetricBody":
        """Scan a pose, take a part of a limb out if asked for, and find the symmetry."""
        shape, points = body[pose], request.count(POINTS)
        whole = request.whole_scan(shape, request.threshold(THRESHOLD), VIEWS)
        if cut:
            request.tell(f"cutting a limb of {shape.name}")
            whole = without_band(body, whole)
        cloud = whole.subsample(points, request.seed)
        each = ScannedPose(shape, cloud, request.diffusion(cloud), 1 - coverage(whole, shape))
        request.tell(f"symmetry of {shape.name}")
        found = intrinsic_symmetry(each.diffusion, seed=request.seed)
        return cls(body, each, found, "a band of one limb taken out" if cut else "")

    @property
    def parts(self) -> NDArray[np.int64]:
        """Component of every point, the largest being 0, (n,)."""
        tree = cKDTree(self.each.scan.points)
        near = tree.sparse_distance_matrix(tree, PARTS * self.each.spacing, output_type="coo_matrix")
        label = connected_components(near, directed=False)[1]
        rank = np.argsort(np.argsort(-np.bincount(label), kind="stable"), kind="stable")
        return np.asarray(rank[label], dtype=np.int64)

    @property
    def note(self) -> str:
        """Missing surface, and the error against the body's true mirror map, in words."""
        error = mirrored_mean(self.body, self.each, self.each, self.found.source_to_target)
        known = "" if np.isnan(error) else f", mean error {error:.1f}"
        return f"{100 * self.each.missing:.0f} % missing{known}"

    def regions(self) -> NDArray[np.int64]:
        """Points whose medial centres are joined to those of their images, each pair once, (m,)."""
        image, centers = self.found.source_to_target, self.each.diffusion.centers
        apart = np.linalg.norm(centers - centers[image], axis=1)
        sure = np.flatnonzero(
            (self.found.confidence >= SURE) & (image >= 0) & (apart > 2 * self.each.spacing)
        )
        if len(sure) == 0:
            return sure
        picked = sure[farthest_points(centers[sure], min(2 * LINES, len(sure)), 0)]
        there = cKDTree(centers[picked]).query(centers[image[picked]])[1]
        kept = np.array([k for k in range(len(picked)) if not (there[there[k]] == k and there[k] < k)])
        return np.asarray(picked[kept][:LINES], dtype=np.int64)


def without_band(body: Collection, whole: Scan) -> Scan:
    """A scan without a band of one limb: of those with a mirror image, that with the foremost, lowest tip.

    Parameters
    ----------
    body
    whole
        A scan of one of its poses.

    Raises
    ------
    InputError
        If the body has no limb.
    """
    rest, distance = body.reference, SurfaceDistance(body.reference)
    limbs = find_limbs(rest, distance, body.mirror)
    if len(limbs) == 0:
        raise InputError(f"{body.subject!r} has no limb to cut; give another data set")
    paired = np.arange(len(limbs))
    if limbs.mirror is not None and (limbs.mirror != paired).any():
        paired = np.flatnonzero((limbs.mirror != paired) & (limbs.mirror >= 0))
    tips = rest.vertices[limbs.tips[paired]]
    tip = limbs.tips[paired[np.argmax(tips[:, (UP + 1) % 3] - tips[:, UP])]]
    corner = rest.faces[whole.face_ids, whole.barycentrics.argmax(axis=1)]
    gap = distance.from_vertices(np.array([tip]))[0][corner] / np.sqrt(rest.area)
    return whole.select((gap < BAND[0]) | (gap > BAND[1]))


@styled
def symmetric_regions(request: FigureRequest) -> MadeFigure:
    """Draw the symmetries of three bodies, or of up to three poses of the data set that is asked for.

    Parameters
    ----------
    request
    """
    if request.dataset is None and not request.poses:
        chosen = [(request.body(name), pose, name == CUT_BODY) for name, pose in BODIES]
    else:
        body = request.body(BODIES[0][0])
        shapes = request.shapes(body, [BODIES[0][1]] * 3, 1, 3)
        chosen = [(body, shape.pose, number == len(shapes) - 1) for number, shape in enumerate(shapes)]
    shown = [SymmetricBody.of(request, *each) for each in chosen]
    note = (
        f"{VIEWS} views, threshold {request.threshold(THRESHOLD):g}, at most {request.count(POINTS):,} "
        f"points, seed {request.seed}. Lines join the medial centres (Eq. 9) of points and of their mirror "
        f"images, evenly spread over the body, where the map's confidence is at least {SURE:g}. Orange: "
        "what is no longer joined to the body; of "
        f"{chosen[-1][0].subject if request.dataset else CUT_BODY} a band of one limb was taken out of the "
        "scan. Errors: mean geodesic distance from the true mirror image, x 100 / √area."
    )
    table = pd.concat([_table(each) for each in shown], ignore_index=True)
    settings = {"shapes": [each.each.shape.name for each in shown], "threshold": request.threshold(THRESHOLD)}
    settings |= {"points": request.count(POINTS), "seed": request.seed}
    sheet = cloud_sheet([[_panel(each) for each in shown]], key=[INNER], note=note)
    return MadeFigure(sheet.figure, table, settings)


def _table(each: SymmetricBody) -> pd.DataFrame:
    """A row per point: its image, confidence and component, and whether its line is drawn."""
    drawn = np.zeros(len(each.each.scan), dtype=bool)
    drawn[each.regions()] = True
    return cloud_table(
        each.body.subject,
        each.each,
        image=each.found.source_to_target,
        confidence=each.found.confidence,
        part=each.parts,
        line=drawn,
    )


def _panel(each: SymmetricBody) -> CloudPanel:
    colors = np.tile([0.83, 0.85, 0.87], (len(each.each.scan), 1))
    colors[each.parts > 0] = (0.96, 0.72, 0.47)
    return CloudPanel(
        each.each.scan.points,
        each.each.scan.normals,
        colors,
        look_from(*VIEWPOINT, up=UP),
        each.body.reference.diagonal,
        title=each.each.shape.name,
        note=each.note,
        overlay=_Lines(each),
    )


class _Lines:
    """Draws the lines of a symmetry over its cloud."""

    def __init__(self, each: SymmetricBody) -> None:
        centers, ids = each.each.diffusion.centers, each.regions()
        self._ends = np.stack([centers[ids], centers[each.found.source_to_target[ids]]], axis=1)
        heights = centers[ids]
        self._colors = position_colors(heights, *np.quantile(centers, [0.01, 0.99], axis=0)) * 0.85

    def __call__(self, axes: Axes, camera: Camera) -> None:
        ends = camera.project(self._ends.reshape(-1, 3))[:, :2].reshape(-1, 2, 2)
        axes.add_collection(LineCollection(list(ends), colors=self._colors, lw=0.9, alpha=0.85))
        for k in (0, 1):
            axes.scatter(
                ends[:, k, 0],
                ends[:, k, 1],
                s=7,
                c=self._colors,
                linewidths=0.3,
                edgecolors="white",
                zorder=4,
            )

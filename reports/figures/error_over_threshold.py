"""Fig. 6 of the paper: the error of Eq. 18 against threshold and pose, with the clouds beside the curves.

On the left the complete rest pose, which all are measured against, and some of the scans; on the right the
curves and, below them, the missing share of the surface.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from datasets_gen import Collection, InputError, Shape
from datasets_gen.meshes.geometry import face_normals
from evaluation import diffusion_error
from medial import Diffusion
from reports.figures.cloud_sheet import INNER, CloudPanel, cloud_sheet
from reports.figures.figure_request import FigureRequest, MadeFigure, front_view
from reports.figures.style import CLAY, plain_numbers, series_styles, styled
from scanner_sim import Scan, coverage, sample

POSES = ("rest", "walk", "arms_up", "kick")
THRESHOLDS = (0.1, 0.3, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95)
VIEWS = 6
POINTS = 3000
SHOWN = 3
"""Thresholds whose clouds are drawn, of each pose."""
PLOT = 3.4
LEAST = 400
"""Points that a scan must have to be compared."""


@dataclass(frozen=True)
class ScanError:
    """A scan at one threshold, and its error against the complete rest pose.

    Attributes
    ----------
    pose : str
    threshold : float
    scan : Scan
    missing, eq18 : float
        Share of the surface in [0, 1]; error of Eq. 18 with the area factor.
    """

    pose: str
    threshold: float
    scan: Scan
    missing: float
    eq18: float


@styled
def error_over_threshold(request: FigureRequest) -> MadeFigure:
    """Measure Eq. 18 of several poses over thresholds.

    Parameters
    ----------
    request
        Its thresholds are the ones compared.

    Raises
    ------
    InputError
        If a scan at the lowest threshold has too few points.
    """
    body = request.body("human")
    shapes = request.shapes(body, POSES, 1, 6)
    if request.dataset is not None and not request.poses:
        shapes = shapes[: len(POSES)]
    thresholds = sorted(set(request.thresholds or THRESHOLDS))
    points = request.count(POINTS)
    request.tell(f"sampling {body.reference.name}")
    complete = sample(body.reference, points, request.seed)
    reference = request.diffusion(complete)
    found: list[ScanError] = []
    for shape in shapes:
        whole = request.whole_scan(shape, thresholds[0], VIEWS)
        for threshold in thresholds:
            each = _error(request, body, shape, whole.accept(threshold), reference, points)
            found += [each] if each is not None else []
    if not found:
        raise InputError(f"no scan of {body.subject!r} has {LEAST} points; give lower thresholds")
    table = pd.DataFrame(
        {
            "pose": [each.pose for each in found],
            "threshold": [each.threshold for each in found],
            "points": [len(each.scan) for each in found],
            "missing": [each.missing for each in found],
            "eq18": [each.eq18 for each in found],
        }
    )
    note = (
        f"{body.subject}: {VIEWS} views, at most {points:,} points, seed {request.seed}; the reference is "
        f"the rest pose sampled completely with {points:,} points. m_t is multiplied by the body's area; "
        "10,000 pairs, 25 times. Below the curves, the share of the surface that no scan point is near. "
        f"Scans of fewer than {LEAST} points are left out."
    )
    settings = {"poses": [s.name for s in shapes], "thresholds": thresholds, "points": points}
    figure = _drawn(body, complete, found, note)
    return MadeFigure(figure, table, settings | {"seed": request.seed})


def _error(
    request: FigureRequest, body: Collection, shape: Shape, accepted: Scan, reference: Diffusion, points: int
) -> ScanError | None:
    """Eq. 18 of a scan; None if it has too few points."""
    if len(accepted) < min(LEAST, points):
        return None
    threshold = accepted.config.peak_threshold
    request.tell(f"{shape.name} at threshold {threshold:g}")
    cloud = accepted.subsample(points, request.seed)
    diffusion = Diffusion.from_points(cloud.points, cloud.normals, modes=len(reference.eigenvalues))
    faces, weights = body.on_reference(shape, cloud.face_ids, cloud.barycentrics)
    rest = body.reference
    normals = face_normals(rest.vertices, rest.faces)[faces]
    error = diffusion_error(
        reference, diffusion, rest.at(faces, weights), normals, rest.area, seed=request.seed
    )
    return ScanError(shape.pose, threshold, cloud, 1 - coverage(accepted, shape), error.eq18)


def _drawn(body: Collection, complete: Scan, found: Sequence[ScanError], note: str) -> Figure:
    """The rest pose and, a row per pose, scans at rising thresholds; curves on the right."""
    poses = list(dict.fromkeys(each.pose for each in found))
    styles = series_styles(poses)
    rows: list[list[CloudPanel | None]] = []
    for pose in poses[:3]:
        of_pose = [each for each in found if each.pose == pose]
        ids = np.unique(np.linspace(0, len(of_pose) - 1, SHOWN + 1).round().astype(int))[1:]
        row: list[CloudPanel | None] = [
            _panel(body, complete, body.reference.pose, "complete: the reference")
        ]
        row = row if not rows else [None]
        for k in ids:
            each = of_pose[k]
            words = f"{100 * each.missing:.0f} % missing, E {each.eq18:.3g}"
            row.append(_panel(body, each.scan, f"{pose}, τ {each.threshold:g}", words, styles[pose]["color"]))
        rows.append(row)
    sheet = cloud_sheet(rows, key=[INNER], note=note, right=PLOT + 0.9, least_height=4.6)
    tall = sheet.bottom - 1.1
    upper = sheet.axes(sheet.right + 0.75, 0.45, PLOT, 0.68 * tall)
    lower = sheet.axes(sheet.right + 0.75, 0.45 + 0.73 * tall, PLOT, 0.27 * tall, sharex=upper)
    _curves(upper, found, styles, "eq18", 1.0)
    _curves(lower, found, styles, "missing", 100.0)
    upper.set_title("error in medial diffusion")
    upper.set_ylabel("E(P, Q), Eq. 18")
    upper.legend(title="pose", loc="upper left")
    upper.tick_params(labelbottom=False)
    upper.set_yscale("log")
    plain_numbers(upper.yaxis)
    thresholds = sorted({each.threshold for each in found})
    lower.set_xticks(thresholds, [f"{value:g}" for value in thresholds], fontsize=6.5, rotation=60)
    lower.set_ylim(bottom=0)
    lower.set_ylabel("missing, %")
    lower.set_xlabel("peak threshold τ")
    return sheet.figure


def _panel(body: Collection, scan: Scan, title: str, note: str, color: str = CLAY) -> CloudPanel:
    colors = np.tile(0.45 + 0.5 * np.array(to_rgb(color)), (len(scan), 1))
    return CloudPanel(
        scan.points, scan.normals, colors, front_view(body), body.reference.diagonal, title=title, note=note
    )


def _curves(
    axes: Axes,
    found: Sequence[ScanError],
    styles: Mapping[str, Mapping[str, Any]],
    what: str,
    factor: float,
) -> None:
    for pose, style in styles.items():
        of_pose = [each for each in found if each.pose == pose]
        values = factor * np.array([getattr(each, what) for each in of_pose])
        axes.plot([each.threshold for each in of_pose], values, label=pose, mec="white", mew=0.5, **style)

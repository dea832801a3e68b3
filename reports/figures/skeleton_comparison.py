"""Fig. 10 of the paper: curve skeletons [TZCO09] of two scans and matching by them, against medial diffusion.

The paper shows that the two skeletons have other branches, so that matching their graphs is ill-posed. Here
the graphs are matched all the same, in the manner of [ZST*10] (`evaluation.methods.skeleton_matching`).
"""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from datasets_gen.records import InputError
from evaluation.methods import MethodInput, create
from medial.skeletons import CurveSkeleton, skeleton_of
from reports.figures.cloud_drawing import carried_colors
from reports.figures.cloud_sheet import FAR, INNER, NEAR, UNMATCHED, CloudPanel, cloud_sheet
from reports.figures.figure_request import FigureRequest, MadeFigure, TwoPoses, front_view, map_errors
from reports.figures.matched_pair import MatchedPair
from reports.figures.skeleton_drawing import SKELETON_KEY, in_words, skeleton_panel
from reports.figures.style import styled

POSES = ("tpose", "walk")
THRESHOLD, VIEWS = 0.9, 6
POINTS = 2500


@styled
def skeleton_comparison(request: FigureRequest) -> MadeFigure:
    """Skeletons of two scans over their clouds, the map that they give, and that of medial diffusion.

    Parameters
    ----------
    request

    Raises
    ------
    InputError
        If the data set has fewer than two poses.
    """
    scanned = TwoPoses.of(request, "human", POSES, THRESHOLD, (VIEWS, VIEWS), POINTS)
    body, source, target = scanned.body, scanned.source, scanned.target
    request.tell("curve skeletons")
    skeletons = [skeleton_of(each.scan.points, each.scan.normals) for each in (source, target)]
    pair = MatchedPair.of(request, body, source, target)
    own, arrived = pair.colours("position")
    image, words = _by_skeletons(request, pair)
    shown = [
        skeleton_panel(
            each.scan.points,
            each.scan.normals,
            skeleton,
            front_view(body),
            body.reference.diagonal,
            title=f"{side}, {each.shape.pose}",
            note=f"ROSA: {in_words(skeleton)}",
        )
        for each, skeleton, side in zip((source, target), skeletons, ("source", "target"), strict=True)
    ]
    landmarks = "landmarks of medial diffusion"
    rows: list[list[CloudPanel | None]] = [
        [
            *shown,
            pair.panel(1, _arrived(image, own, pair), landmarks=False, title="by skeletons", note=words),
        ],
        [
            pair.panel(0, own, title="source, colours", note=landmarks),
            pair.panel(1, arrived, title="medial diffusion", note=pair.error_words),
            None,
        ],
    ]
    note = (
        f"{source.shape.name} and {target.shape.name}: {VIEWS} views, threshold {scanned.threshold:g}, at "
        f"most {scanned.points:,} points, seed {request.seed}; {100 * source.missing:.0f} and "
        f"{100 * target.missing:.0f} % of the surface are missing. Colours: the position of the source's "
        "points; the targets have those that a map sends to them. Errors: geodesic distance from the true "
        "place, x 100 / √area."
    )
    sheet = cloud_sheet(rows, key=[*SKELETON_KEY, NEAR, FAR, INNER, UNMATCHED], note=note)
    tables = [pair.table("medial diffusion", by_skeletons=image)]
    tables += [_nodes(side, each) for side, each in zip(("source", "target"), skeletons, strict=True)]
    return MadeFigure(sheet.figure, pd.concat(tables, ignore_index=True), scanned.settings)


def _by_skeletons(request: FigureRequest, pair: MatchedPair) -> tuple[NDArray[np.int64], str]:
    """Target points by skeleton matching, -1 for all where it fails, and its errors in words."""
    request.tell("matching the skeletons")
    sides = [
        MethodInput(name, each.scan) for name, each in (("source", pair.source), ("target", pair.target))
    ]
    try:
        found = create("skeleton", {}).match(sides[0], sides[1], request.seed)
    except InputError as error:
        request.tell(str(error))
        return np.full(len(pair.source.scan), -1), "no map"
    errors = map_errors(pair.body, pair.source, pair.target, found.source_to_target)
    return found.source_to_target, f"mean error {np.nanmean(errors):.1f}, median {np.nanmedian(errors):.1f}"


def _arrived(image: NDArray[np.int64], own: NDArray[np.float64], pair: MatchedPair) -> NDArray[np.float64]:
    return carried_colors(image, own, pair.target.scan.points)


def _nodes(side: str, skeleton: CurveSkeleton) -> pd.DataFrame:
    """A row per node of a skeleton."""
    places = {axis: skeleton.nodes[:, k] for k, axis in enumerate("xyz")}
    head = {"panel": "curve skeletons", "cloud": side, "point": np.arange(len(skeleton))}
    return pd.DataFrame(head | places | {"radius": skeleton.radii, "kind": skeleton.kinds})

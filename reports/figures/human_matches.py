"""Fig. 8 of the paper: landmarks and dense maps of scanned humans, coloured by the medial embedding."""

import numpy as np
import pandas as pd

from datasets_gen import InputError
from reports.figures.cloud_sheet import FAR, INNER, NEAR, UNMATCHED, cloud_sheet
from reports.figures.figure_request import FigureRequest, MadeFigure, ScannedPose
from reports.figures.matched_pair import ALONE, MatchedPair
from reports.figures.style import styled

PAIRS = (("walk", "sit"), ("rest", "kick"))
MOST = 8
"""Poses that fit the sheet."""
THRESHOLD, VIEWS = 0.7, 6
POINTS = 3000


@styled
def human_matches(request: FigureRequest) -> MadeFigure:
    """Match two pairs of poses, or up to four of those that are asked for.

    Parameters
    ----------
    request
        Its poses are taken two by two.

    Raises
    ------
    InputError
        If the number of poses is odd, or there are too few.
    """
    body = request.body("human")
    own = [pose for pair in PAIRS for pose in pair]
    shapes = request.shapes(body, own, 2, MOST if request.poses else len(own))
    if request.poses and len(shapes) % 2:
        raise InputError(
            f"figure {request.number} shows pairs of poses, got {len(shapes)}; give an even number"
        )
    shapes = shapes[: len(shapes) // 2 * 2]
    threshold, points = request.threshold(THRESHOLD), request.count(POINTS)
    pairs = []
    for k in range(0, len(shapes), 2):
        source, target = (
            ScannedPose.of(request, each, threshold, VIEWS, points) for each in shapes[k : k + 2]
        )
        pairs.append(MatchedPair.of(request, body, source, target))
    row = []
    for pair in pairs:
        for side, colors in enumerate(pair.colours()):
            role, each = (("source", pair.source), ("target", pair.target))[side]
            words = f"{100 * each.missing:.0f} % missing" + (
                f", error {np.nanmean(pair.errors):.1f}" if side else ""
            )
            row.append(pair.panel(side, colors, title=f"{role}, {each.shape.pose}", note=words))
    note = (
        f"{body.subject}: {VIEWS} views, threshold {threshold:g}, at most {points:,} points, seed "
        f"{request.seed}. Pairs from left to right. Colours: where the source's medial centres (Eq. 9) "
        f"lie; the target has those that the map sends to it. {ALONE} Errors: mean geodesic distance from "
        "the true place, x 100 / √area."
    )
    sheet = cloud_sheet([row], key=[NEAR, FAR, INNER, UNMATCHED], note=note)
    tables = [pair.table(f"pair {k + 1}") for k, pair in enumerate(pairs)]
    settings = {"poses": [s.name for s in shapes], "threshold": threshold, "points": points}
    return MadeFigure(sheet.figure, pd.concat(tables, ignore_index=True), settings | {"seed": request.seed})

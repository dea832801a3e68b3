"""Fig. 11 of the paper: against heat kernel matching [OMMG10], coloured by the position of the points.

Both operators get the same landmark search and extrapolation: what differs is the diffusion. Above, the
default matcher, which judges maps by deforming one scan onto the other; below, that of Sec. 4.
"""

import numpy as np
import pandas as pd

from reports.figures.cloud_sheet import FAR, INNER, NEAR, UNMATCHED, CloudPanel, cloud_sheet
from reports.figures.figure_request import FigureRequest, MadeFigure, TwoPoses
from reports.figures.matched_pair import MatchedPair
from reports.figures.style import styled

POSES = ("walk", "sit")
THRESHOLD, VIEWS = 0.8, 6
POINTS = 2500
MATCHERS = {"default": "default matcher", "paper": "matcher of Sec. 4"}
OPERATORS = {"medial": "medial diffusion", "heat": "heat kernel"}


@styled
def heat_kernel_comparison(request: FigureRequest) -> MadeFigure:
    """Match two poses by medial diffusion and by the heat kernel, with both matchers.

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
    rows, tables = [], []
    for config in MATCHERS:
        row: list[CloudPanel | None] = []
        for operator, name in OPERATORS.items():
            pair = MatchedPair.of(request, body, source, target, operator, config)
            own, arrived = pair.colours("position")
            row.append(
                pair.panel(0, own, title=f"source, {source.shape.pose}", note=f"landmarks of {operator}")
            )
            row.append(pair.panel(1, arrived, title=name, note=_words(pair)))
            tables.append(pair.table(f"{name}, {MATCHERS[config]}"))
        rows.append(row)
    note = (
        f"{source.shape.name} and {target.shape.name}: {VIEWS} views, threshold {scanned.threshold:g}, at "
        f"most {scanned.points:,} points, seed {request.seed}; {100 * source.missing:.0f} and "
        f"{100 * target.missing:.0f} % of the surface are missing. Colours: the position of the source's "
        "points; the targets have those that the map sends to them. Errors: mean geodesic distance from "
        "the true place, x 100 / √area; mirrored: from the place that mirrors it, which is small where "
        "left and right are swapped."
    )
    sheet = cloud_sheet(rows, names=list(MATCHERS.values()), key=[NEAR, FAR, INNER, UNMATCHED], note=note)
    return MadeFigure(sheet.figure, pd.concat(tables, ignore_index=True), scanned.settings)


def _words(pair: MatchedPair) -> str:
    mirrored = pair.mirrored_mean
    direct = f"mean error {np.nanmean(pair.errors):.1f}"
    return direct if np.isnan(mirrored) else f"{direct}, mirrored {mirrored:.1f}"

"""Fig. 9 of the paper: a match of two quadrupeds, with an inset of how their signatures m_t(x, x) differ."""

from dataclasses import replace

import numpy as np
from matplotlib.colors import Normalize
from numpy.typing import NDArray

from medial.spectrum.times import logarithmic_times
from reports.figures.cloud_drawing import ERROR_COLORS
from reports.figures.cloud_sheet import FAR, INNER, NEAR, UNMATCHED, CloudPanel, ColourBar, cloud_sheet
from reports.figures.figure_request import FigureRequest, MadeFigure, TwoPoses
from reports.figures.matched_pair import ALONE, MatchedPair
from reports.figures.signature_colours import (
    LABEL,
    SIGNATURE,
    few_ticks,
    shared_norm,
    signature_colors,
    signatures,
)
from reports.figures.style import styled

POSES = ("stand", "gallop_extended")
THRESHOLD, VIEWS = 0.7, 6
POINTS = 3000
TIMES = 25
SHOWN = 8
"""Time of the signature that the inset shows, of all."""
INSET = 0.6
"""Size of the bodies of the inset, of those of the map."""


@styled
def quadruped_matches(request: FigureRequest) -> MadeFigure:
    """Match two poses, and compare their signatures along the map.

    Parameters
    ----------
    request

    Raises
    ------
    InputError
        If the data set has fewer than two poses.
    """
    scanned = TwoPoses.of(request, "quadruped", POSES, THRESHOLD, (VIEWS, VIEWS), POINTS)
    body, source, target = scanned.body, scanned.source, scanned.target
    pair = MatchedPair.of(request, body, source, target)
    times = logarithmic_times(source.diffusion.eigenvalues, target.diffusion.eigenvalues, count=TIMES)
    here, there = (signatures(each.diffusion, times, body.reference.area) for each in (source, target))
    change = signature_change(here, there, pair.found.source_to_target)
    note = (
        f"{body.subject}: {VIEWS} views, threshold {scanned.threshold:g}, seed {request.seed}; source "
        f"{source.note}, target {target.note}. Colours of the map: where the source's medial centres (Eq. "
        f"9) lie; the target has those that the map sends to it. {ALONE} Geodesic {pair.error_words} (x "
        f"100 / √area). Inset: the signature of both at t = {times[SHOWN]:.3g} on one scale, and the mean "
        f"over {TIMES} times of |ln m_t(x, x) - ln m_t(y, y)| between each source point x and its match y."
    )
    rows = [[*_map(pair), *_inset(pair, here[:, SHOWN], there[:, SHOWN], change)]]
    norm = shared_norm([here[:, SHOWN], there[:, SHOWN]])
    bars = [
        ColourBar(norm, SIGNATURE, LABEL, 2, few_ticks(norm)),
        ColourBar(_scale(change), ERROR_COLORS, "mean change of ln m_t(x, x)", 4),
    ]
    sheet = cloud_sheet(rows, bars=bars, key=[NEAR, FAR, INNER, UNMATCHED], note=note)
    table = pair.table(signature=here[:, SHOWN], signature_change=change)
    table.loc[table["panel"] == "target", "signature"] = there[:, SHOWN]
    return MadeFigure(sheet.figure, table, scanned.settings)


def signature_change(
    here: NDArray[np.float64], there: NDArray[np.float64], image: NDArray[np.integer]
) -> NDArray[np.float64]:
    """Mean over the times of |ln m_t(x, x) - ln m_t(y, y)| between points and their matches, (n,).

    Parameters
    ----------
    here : (n, T), there : (m, T)
        Signatures.
    image : (n,)
        Target point of each source point; nan comes back for -1.
    """
    change = np.abs(np.log(np.maximum(here, 1e-300)) - np.log(np.maximum(there[image], 1e-300))).mean(axis=1)
    return np.where(image >= 0, change, np.nan)


def _scale(change: NDArray[np.float64]) -> Normalize:
    return Normalize(0, max(float(np.nanquantile(change, 0.98)), 1e-6), clip=True)


def _map(pair: MatchedPair) -> list[CloudPanel]:
    own, arrived = pair.colours()
    shapes = pair.source.shape, pair.target.shape
    return [
        pair.panel(0, own, title=f"source, {shapes[0].pose}"),
        pair.panel(1, arrived, title=f"target, {shapes[1].pose}"),
    ]


def _inset(
    pair: MatchedPair, here: NDArray[np.float64], there: NDArray[np.float64], change: NDArray[np.float64]
) -> list[CloudPanel]:
    norm = shared_norm([here, there])
    shown = np.asarray(ERROR_COLORS(_scale(change)(np.nan_to_num(change)))[:, :3])
    panels = [
        pair.panel(0, signature_colors(here, norm), title="inset: signature", note="source", landmarks=False),
        pair.panel(1, signature_colors(there, norm), title="signature", note="target", landmarks=False),
        pair.panel(0, shown, title="difference", note="on the source", landmarks=False),
    ]
    return [replace(panel, size=panel.size / INSET) for panel in panels]

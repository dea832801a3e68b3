"""One view of a contact sheet: its hits, what was measured of them, and what became of each."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scanner_sim.optics.hits import Hits
from scanner_sim.optics.measurement import Samples, ViewMeasurement, samples
from scanner_sim.optics.verdict import Verdict, verdicts
from scanner_sim.scanner import Rig

LEVELS = (0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95)
"""Peak thresholds that sweeps commonly use."""


@dataclass(frozen=True)
class SheetView:
    """A view as the sheet shows it.

    Attributes
    ----------
    number : int
    hits : Hits
        n camera rays.
    measured : ViewMeasurement
    judged : (n,) int8
        `Verdict` on every hit.
    peak : (n,) float64
        Fitted peak of accepted hits, NaN elsewhere: the largest threshold at which the hit is still accepted.
    """

    number: int
    hits: Hits
    measured: ViewMeasurement
    judged: NDArray[np.int8]
    peak: NDArray[np.float64]

    @property
    def on_object(self) -> NDArray[np.bool_]:
        """Hits that see the object and not what is behind it, (n,)."""
        return self.judged != Verdict.MISS


def scanned(rig: Rig, number: int, seed: int) -> SheetView:
    """Look from one viewpoint of a rig."""
    hits, measured = rig.view(number, seed)
    judged = verdicts(hits, measured.index, measured.verdict, rig.config_of(number))
    accepted = measured.verdict == Verdict.ACCEPTED
    of_pixel = np.full(rig.config.resolution[::-1], np.nan)
    if rig.passes:
        of_pixel = np.full(hits.pixels.max(axis=0, initial=0)[::-1] + 1, np.nan)
    column, row = hits.pixels[measured.index[accepted]].T
    of_pixel[row, column] = measured.peak[accepted]
    peak = of_pixel[hits.pixels[:, 1], hits.pixels[:, 0]]  # all rays of a pixel share its peak
    peak[judged == Verdict.MISS] = np.nan
    return SheetView(number, hits, measured, judged, peak)


def stored_samples(rig: Rig, view: SheetView, seed: int) -> Samples:
    """What the sensor stored of a view's lit pixels; of more than one bounce, the direct light alone."""
    return samples(view.hits, rig.config_of(view.number), seed, view.number)


def levels(lowest: float) -> list[float]:
    """The threshold of a scan and the common ones above it."""
    return [lowest, *(level for level in LEVELS if level > lowest + 1e-9)]


def accepted_shares(views: list[SheetView], thresholds: list[float]) -> NDArray[np.float64]:
    """Share of the pixels on the object, over all views, that are accepted at each threshold."""
    total = max(sum(int(view.on_object.sum()) for view in views), 1)
    peaks = np.concatenate([view.peak[~np.isnan(view.peak)] for view in views] or [np.empty(0)])
    return np.array([(peaks >= threshold).sum() / total for threshold in thresholds])

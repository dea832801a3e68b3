"""Intensities over time of single pixels with the peak that was fitted: one accepted, one for each reason."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from scanner_sim.optics.verdict import Verdict
from scanner_sim.output.sheet_panels import COLOURS, verdict_name
from scanner_sim.output.sheet_view import SheetView, stored_samples
from scanner_sim.scanner import Rig

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_WHY = {
    Verdict.SHADOW: "no sample:\nanother part of the object\nis in the laser's way",
    Verdict.GRAZING: "no sample:\nthe surface faces away\nfrom the laser",
}


@dataclass(frozen=True)
class PixelProfile:
    """What one pixel saw.

    Attributes
    ----------
    view : int
    pixel : (2,) int32
        Column and row.
    verdict : Verdict
    angle, value : (w,) float64
        Sheet angle of each sample in degrees, and the intensity stored less the dark frame; empty if unlit.
    fit : tuple of float
        Peak, angle and width of the fitted Gaussian, degrees; NaN without one.
    ceiling, threshold : float
        Intensities at which the sensor saturates, and below which peaks are rejected.
    """

    view: int
    pixel: NDArray[np.int32]
    verdict: Verdict
    angle: NDArray[np.float64]
    value: NDArray[np.float64]
    fit: tuple[float, float, float]
    ceiling: float
    threshold: float


def profiles(rig: Rig, views: list[SheetView], shown: list[int], seed: int) -> list[PixelProfile]:
    """A pixel of every verdict that occurs, the accepted one first; none of a line profiler.

    Parameters
    ----------
    rig
    views
        All views of the rig.
    shown
        Numbers of the views that are searched first, in order; the others follow.
    seed
        Of the noise.
    """
    if rig.passes:
        return []  # its peaks lie across the line in a frame, not over time
    order = [views[k] for k in shown] + [view for k, view in enumerate(views) if k not in shown]
    found = []
    for verdict in list(Verdict)[1:]:
        seen = [view for view in order if (view.judged == verdict).any()]
        lit = [view for view in seen if (view.judged[view.measured.index] == verdict).any()]
        if seen:
            found.append(_typical(rig, (lit or seen)[0], verdict, seed))
    return found


def _typical(rig: Rig, view: SheetView, verdict: Verdict, seed: int) -> PixelProfile:
    """The pixel of a verdict whose peak is the median; where none is lit, the middle one."""
    row = np.flatnonzero(view.judged[view.measured.index] == verdict)
    if len(row):
        peak = np.nan_to_num(view.measured.peak[row])
        return _of_row(rig, view, int(row[np.argsort(peak, kind="stable")[len(row) // 2]]), verdict, seed)
    hit = np.flatnonzero(view.judged == verdict)
    empty, nan = np.empty(0), (math.nan, math.nan, math.nan)
    pixel = view.hits.pixels[hit[len(hit) // 2]]
    return PixelProfile(view.number, pixel, verdict, empty, empty, nan, math.nan, rig.config.peak_threshold)


def _of_row(rig: Rig, view: SheetView, row: int, verdict: Verdict, seed: int) -> PixelProfile:
    """The profile of a measured pixel."""
    config, measured = rig.config_of(view.number), view.measured
    stored = stored_samples(rig, view, seed)
    values = stored.rows.padded(np.array([row]))[0]
    number = stored.rows.first[row] + np.arange(len(values))
    angle = np.degrees(config.sweep[0] + (number + 0.5) * config.step)
    fit = (measured.peak[row], math.degrees(measured.angle[row]), math.degrees(measured.width[row]))
    return PixelProfile(
        view.number,
        stored.pixels[row],
        verdict,
        angle,
        values,
        fit,
        float(stored.ceiling[row]),
        config.peak_threshold,
    )


def draw(axes: "Axes", profile: PixelProfile) -> None:
    """Draw samples, fit, threshold and ceiling."""
    column, row = profile.pixel
    colour = COLOURS[profile.verdict]
    axes.set_title(
        f"{verdict_name(profile.verdict)}: view {profile.view}, column {column}, row {row}", fontsize=10
    )
    axes.spines[["top", "right"]].set_visible(False)
    axes.axhline(profile.threshold, color="#555555", lw=0.9, ls="--", label="peak threshold")
    axes.set_xlabel("angle of the sheet (degrees)", fontsize=9)
    axes.set_ylabel("stored intensity", fontsize=9)
    axes.tick_params(labelsize=8)
    axes.locator_params(axis="x", nbins=5)
    if len(profile.angle) == 0:
        axes.text(0.5, 0.55, _WHY.get(profile.verdict, "no sample"), ha="center", va="center", fontsize=9,
                  transform=axes.transAxes)  # fmt: skip
        axes.set_xticks([])
        axes.set_ylim(0, 1.08)
        axes.legend(fontsize=7.5, frameon=False, loc="upper right")
        return
    axes.vlines(profile.angle, 0, profile.value, color=colour, lw=1.2, alpha=0.7)
    axes.plot(profile.angle, profile.value, "o", ms=3.5, color=colour, label="samples")
    peak, middle, width = profile.fit
    if math.isfinite(peak) and width > 0:
        x = np.linspace(profile.angle[0], profile.angle[-1], 300)
        label = f"fit: peak {peak:.3f}, width {width:.3f} degrees"
        axes.plot(x, peak * np.exp(-(((x - middle) / width) ** 2)), color="#222222", lw=1.1, label=label)
        axes.axvline(middle, color="#222222", lw=0.6, ls=":")
    top = max(float(profile.value.max()), peak if math.isfinite(peak) else 0, profile.threshold)
    if top > 0.8 * profile.ceiling:
        axes.axhline(profile.ceiling, color="#b07d00", lw=0.9, ls="-.", label="saturation")
        top = max(top, profile.ceiling)
    axes.set_ylim(min(0, float(profile.value.min())), 1.7 * top)
    axes.legend(fontsize=7.5, frameon=False, loc="upper right")

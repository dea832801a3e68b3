"""A contact sheet of one scan: the rig, every view, intensities over time, and what each threshold drops."""

import os
from typing import TYPE_CHECKING, Any

import numpy as np

from datasets_gen.records import InputError, atomic_path
from datasets_gen.shape import Shape
from scanner_sim.output import pixel_profiles, sheet_panels
from scanner_sim.output.sheet_view import SheetView, scanned
from scanner_sim.scanner import Rig, facing_outward
from scanner_sim.scanner_config import ScannerConfig
from scanner_sim.tracing.materials import Attributes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_VIEWS = 24
"""Views shown; of more, so many are taken evenly."""
VIEWS_PER_ROW = 2
WIDTH = 17.0
"""Of the sheet, inches."""


def write_contact_sheet(
    shape: Shape,
    path: str | os.PathLike[str],
    config: ScannerConfig | None = None,
    seed: int = 0,
    view: int | None = None,
    attributes: Attributes | None = None,
) -> None:
    """Scan a shape and write its contact sheet.

    Parameters
    ----------
    shape, config, seed, attributes
        As for `scan`.
    path
        ``.png``, ``.pdf`` or ``.svg``.
    view
        Number of the only viewpoint that is shown; all of them if not given.

    Raises
    ------
    InputError
        If there is no such view, or the scan is impossible.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    config = ScannerConfig() if config is None else config
    rig = Rig(facing_outward(shape), config, attributes)
    if view is not None and not 0 <= view < len(rig.poses):
        raise InputError(f"there is no view {view!r} to show; the rig has views 0..{len(rig.poses) - 1}")
    views = [scanned(rig, number, seed) for number in range(len(rig.poses))]
    shown = [view] if view is not None else _evenly(len(views))
    figure = Figure(figsize=(WIDTH, 10), dpi=100)
    FigureCanvasAgg(figure)
    draw_contact_sheet(figure, rig, views, shown, seed)
    with atomic_path(path) as temporary:
        figure.savefig(temporary)


def draw_contact_sheet(
    figure: "Figure", rig: Rig, views: list[SheetView], shown: list[int], seed: int
) -> None:
    """Fill a figure, whose height is set to what the panels need.

    Parameters
    ----------
    figure
    rig
    views
        All views of the rig.
    shown
        Numbers of the views that are shown as images; the first is drawn in the rig.
    seed
        Of the noise.
    """
    profiles = pixel_profiles.profiles(rig, views, shown, seed)
    profile_columns = max(len(profiles) if len(profiles) <= 5 else -(-len(profiles) // 2), 1)
    profile_rows = max(-(-len(profiles) // profile_columns), 1)
    image_rows = -(-len(shown) // VIEWS_PER_ROW)
    heights = [5.2, 2.7 * profile_rows if profiles else 0.1, 3.1 * image_rows]
    figure.set_size_inches(WIDTH, sum(heights) + 0.6)
    figure.set_layout_engine("constrained")
    parts: Any = figure.subfigures(3, 1, height_ratios=heights)
    _overview(parts[0], rig, views, shown)
    places = _grid(parts[1], profile_rows, profile_columns, len(profiles))
    for axes, profile in zip(places, profiles, strict=True):
        pixel_profiles.draw(axes, profile)
    columns = 3 * min(VIEWS_PER_ROW, len(shown))
    panels = _grid(parts[2], image_rows, columns, 3 * len(shown))
    for k, number in enumerate(shown):
        sheet_panels.view_panels(panels[3 * k : 3 * k + 3], rig, views[number])
    config = rig.config
    count = f"{len(views)} view{'s' * (len(views) > 1)}"
    if 1 < len(shown) < len(views):
        count = f"{len(shown)} of {count}"
    figure.suptitle(
        f"{rig.shape.name}: {count}, {config.resolution[0]} x {config.resolution[1]} pixels, "
        f"{config.stripes} stripes, fit {config.fit!r}, peak threshold {config.peak_threshold:g}",
        fontsize=14,
    )


def _overview(part: Any, rig: Rig, views: list[SheetView], shown: list[int]) -> None:
    """The rig, the shares of the verdicts, and what each threshold drops."""
    places = part.add_gridspec(1, 3, width_ratios=[1.1, 1, 1.1])
    sheet_panels.rig_panel(part.add_subplot(places[0], projection="3d"), rig, shown[0])
    sheet_panels.share_panel(part.add_subplot(places[1]), views)
    sheet_panels.threshold_panel(part.add_subplot(places[2]), views, rig.config)


def _grid(part: Any, rows: int, columns: int, count: int) -> list[Any]:
    """The first axes of a grid, row by row."""
    places = part.add_gridspec(rows, columns)
    return [part.add_subplot(places[k // columns, k % columns]) for k in range(count)]


def _evenly(count: int) -> list[int]:
    """Numbers of the views to show: all, or as many as fit, evenly."""
    return np.unique(np.linspace(0, count - 1, min(count, MOST_VIEWS)).round().astype(int)).tolist()

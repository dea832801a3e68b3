"""A contact sheet of one scan: the rig, what a camera sees, a stripe, intensities and verdicts."""

import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError, atomic_path
from datasets_gen.shape import Shape
from scanner_sim.optics import sensor, stripe
from scanner_sim.optics.hits import Hits
from scanner_sim.optics.measurement import Verdict, ViewMeasurement, intensities, verdicts
from scanner_sim.scanner import Rig, facing_outward
from scanner_sim.scanner_config import ScannerConfig
from scanner_sim.tracing.materials import Attributes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {
    Verdict.MISS: "#ffffff",
    Verdict.ACCEPTED: "#4daf6a",
    Verdict.SHADOW: "#2b2d42",
    Verdict.GRAZING: "#3a86c8",
    Verdict.DARK: "#8d6e63",
    Verdict.SATURATED: "#f2c14e",
    Verdict.OUT_OF_RANGE: "#b56bb8",
    Verdict.POOR_FIT: "#d1495b",
}
"""Of the verdicts; told apart in greys and by the colour-blind too."""


def write_contact_sheet(
    shape: Shape,
    path: str | os.PathLike[str],
    config: ScannerConfig | None = None,
    seed: int = 0,
    view: int = 0,
    attributes: Attributes | None = None,
) -> None:
    """Scan a shape and write the contact sheet of one view.

    Parameters
    ----------
    shape, config, seed, attributes
        As for `scan`.
    path
        ``.png``, ``.pdf`` or ``.svg``.
    view
        Number of the viewpoint that is shown.

    Raises
    ------
    InputError
        If there is no such view, or the scan is impossible.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    config = ScannerConfig() if config is None else config
    rig = Rig(facing_outward(shape), config, attributes)
    if not 0 <= view < len(rig.poses):
        raise InputError(f"there is no view {view!r} to show; the rig has views 0..{len(rig.poses) - 1}")
    views = [rig.view(number, seed) for number in range(len(rig.poses))]
    judged = [verdicts(hits, measured, rig.config) for hits, measured in views]
    figure = Figure(figsize=(15, 9.5), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    draw_contact_sheet(figure, rig, *views[view], judged, view, seed)
    with atomic_path(path) as temporary:
        figure.savefig(temporary)


def draw_contact_sheet(
    figure: "Figure",
    rig: Rig,
    hits: Hits,
    measured: ViewMeasurement,
    judged: list[NDArray[np.int8]],
    view: int,
    seed: int,
) -> None:
    """Fill a figure with the six panels.

    Parameters
    ----------
    figure
    rig
    hits, measured
        Of the view that is shown.
    judged
        Verdicts on the hits of every view.
    view
        Number of the view that is shown.
    seed
        Of the noise.
    """
    camera, one_stripe, peak = _images(rig, view, hits, measured, seed)
    axes = [figure.add_subplot(2, 3, k + 1, projection="3d" if k == 0 else None) for k in range(6)]
    _rig_panel(axes[0], rig, view)
    _image_panel(axes[1], hits, camera, f"what camera {view} sees", cmap="gray", vmin=0, vmax=1)
    _image_panel(axes[2], hits, one_stripe, "one stripe of the sweep", cmap="gray", vmin=0, vmax=1)
    shown = _image_panel(axes[3], hits, peak, "intensity: fitted peak", cmap="viridis", vmin=0, vmax=1)
    figure.colorbar(shown, ax=axes[3], shrink=0.8)
    _verdict_panel(axes[4], hits, judged[view])
    _share_panel(axes[5], judged)
    config = rig.config
    figure.suptitle(
        f"{rig.shape.name}: {len(rig.poses)} views, {config.resolution[0]} x {config.resolution[1]} pixels, "
        f"{config.stripes} stripes, peak threshold {config.peak_threshold:g}"
    )


def _images(
    rig: Rig, view: int, hits: Hits, measured: ViewMeasurement, seed: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Values of the hits: shaded by a lamp at the camera, lit by one stripe, and fitted peaks."""
    config = rig.config
    camera = -np.einsum("nd,nd->n", hits.normals, hits.points) / np.linalg.norm(hits.points, axis=1)
    laser = stripe.laser_coordinates(hits.points[measured.index], config.baseline)
    rng = np.random.default_rng([seed, view])
    first, values = intensities(hits, measured.index, laser, config, rng)
    number = int(np.median(first + values.shape[1] // 2)) if len(first) else 0
    column = number - first
    inside = (column >= 0) & (column < values.shape[1])
    lit = np.take_along_axis(values, np.clip(column, 0, values.shape[1] - 1)[:, None], axis=1)[:, 0]
    one_stripe, peak = np.zeros(len(camera)), np.full(len(camera), np.nan)
    one_stripe[measured.index] = np.where(inside, lit, 0)
    accepted = measured.verdict == Verdict.ACCEPTED
    peak[measured.index[accepted]] = measured.peak[accepted]
    ambient = 0.08 * np.clip(camera, 0, 1)
    return np.clip(camera, 0, 1), sensor.quantise(one_stripe + ambient, config.bits), peak


def _bounds(hits: Hits) -> tuple[int, int, int, int]:
    """First and last column, first and last row of the object, with a margin."""
    low, high = hits.pixels.min(axis=0) - 6, hits.pixels.max(axis=0) + 7
    return int(low[0]), int(high[0]), int(low[1]), int(high[1])


def _image_panel(axes: "Axes", hits: Hits, values: NDArray[Any], title: str, **style: Any) -> Any:
    """Show values of hits as an image, cropped to the object."""
    left, right, top, bottom = _bounds(hits)
    image = np.full((bottom - top, right - left, *values.shape[1:]), np.nan)
    image[hits.pixels[:, 1] - top, hits.pixels[:, 0] - left] = values
    axes.set_title(title, fontsize=11)
    axes.set_facecolor("#101218" if style.get("cmap") == "gray" else "#f4f4f2")
    axes.set_xticks([])
    axes.set_yticks([])
    return axes.imshow(image, extent=(left, right, bottom, top), interpolation="nearest", **style)


def _verdict_panel(axes: "Axes", hits: Hits, judged: NDArray[np.int8]) -> None:
    """Show what became of each pixel of the object."""
    from matplotlib.colors import to_rgb
    from matplotlib.patches import Patch

    table = np.array([to_rgb(COLOURS[verdict]) for verdict in Verdict])
    _image_panel(axes, hits, table[judged], "accepted and rejected pixels")
    present = [verdict for verdict in Verdict if (judged == verdict).any()]
    handles = [
        Patch(color=COLOURS[v], label=f"{_name(v)} {100 * (judged == v).mean():.1f} %") for v in present
    ]
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.02, 1), fontsize=9, frameon=False)


def _share_panel(axes: "Axes", judged: list[NDArray[np.int8]]) -> None:
    """Show the shares of the verdicts in every view as stacked bars."""
    numbers = np.arange(len(judged))
    base = np.zeros(len(judged))
    for verdict in list(Verdict)[1:]:
        share = np.array([100 * (each == verdict).mean() for each in judged])
        if share.any():
            axes.bar(numbers, share, bottom=base, color=COLOURS[verdict], label=_name(verdict), width=0.8)
        base += share
    axes.set_title("pixels of the object in every view", fontsize=11)
    axes.set_xlabel("view")
    axes.set_xticks(numbers[:: max(1, len(numbers) // 10)])
    axes.set_ylabel("% of the pixels that see the object")
    axes.set_ylim(0, 100)
    axes.set_xlim(-0.6, len(judged) - 0.4)
    axes.spines[["top", "right"]].set_visible(False)


def _name(verdict: Verdict) -> str:
    return verdict.name.lower().replace("_", " ")


def _rig_panel(axes: Any, rig: Rig, view: int) -> None:
    """Draw the object, all cameras, and camera, laser and swept frustum of one view; up is up."""
    config = rig.config
    upward = "xyz".index(config.up)
    order = [(upward + 1) % 3, (upward + 2) % 3, upward]
    pose = rig.poses[view]

    def line(points: NDArray[np.float64], **style: Any) -> None:
        axes.plot(*points[:, order].T, **style)

    step = max(1, len(rig.tracer.vertices) // 3000)
    axes.scatter(*rig.tracer.vertices[::step, order].T, s=1, c="#9a9a9a", alpha=0.5, linewidths=0)
    eyes = rig.poses[:, :3, 3]
    axes.scatter(*eyes[:, order].T, c="#9db4d0", s=14)
    laser = pose[:3, 3] + config.baseline * pose[:3, 0]
    axes.scatter(*pose[:3, 3][order], c="#1d4e89", s=45, label="camera")
    axes.scatter(*laser[order], c="#d1495b", s=45, label="laser")
    line(np.stack([pose[:3, 3], laser]), color="#555555", lw=1)
    depth = float(np.linalg.norm(pose[:3, 3]) + rig.tracer.frame.diagonal / 2)
    corners = np.array([[x, y, 1] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], float) * depth
    corners[:, :2] *= config.half_width
    corners[:, 1] *= config.resolution[1] / config.resolution[0]
    far = corners @ pose[:3, :3].T + pose[:3, 3]
    for corner in far:
        line(np.stack([pose[:3, 3], corner]), color="#1d4e89", lw=0.8, alpha=0.6)
    line(far[[0, 1, 2, 3, 0]], color="#1d4e89", lw=0.8, alpha=0.6)
    for angle in config.sweep:
        reach = depth / max(np.cos(angle), 0.5)
        edge = laser + reach * (np.sin(angle) * pose[:3, 0] + np.cos(angle) * pose[:3, 2])
        line(np.stack([laser, edge]), color="#d1495b", lw=1, ls="--", alpha=0.8)
    axes.set_title("the rig (mm): camera's frustum, laser's sweep", fontsize=11)
    axes.legend(loc="upper left", fontsize=8)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=7)

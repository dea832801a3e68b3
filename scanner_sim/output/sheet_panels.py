"""Panels of a contact sheet: the rig, shares of verdicts and thresholds, and the images of a view."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from scanner_sim.optics import stripe
from scanner_sim.optics.verdict import Verdict
from scanner_sim.output.sheet_view import SheetView, accepted_shares, levels
from scanner_sim.scanner import Rig
from scanner_sim.scanner_config import ScannerConfig

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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

RIG_ZOOM = 1.15
"""Of the drawing of the rig, whose corners are empty."""
NEVER = "#d8d5cf"
"""Of pixels that no threshold accepts."""


def verdict_name(verdict: Verdict) -> str:
    """A verdict in plain words."""
    return verdict.name.lower().replace("_", " ")


def threshold_colours(count: int) -> list[Any]:
    """Colours of so many thresholds, from dark (lost first) to bright (survives longest)."""
    from matplotlib import colormaps

    return [colormaps["viridis"](x) for x in np.linspace(0.05, 0.97, count)]


def view_panels(axes: list["Axes"], rig: Rig, view: SheetView) -> None:
    """Three images of a view: shaded with one stripe, verdicts, and the largest threshold survived."""
    from matplotlib.colors import to_rgb

    title = f"view {view.number}"
    if not view.on_object.any():
        for each in axes:
            each.set_axis_off()
        axes[1].text(0.5, 0.5, f"{title} sees nothing", ha="center", va="center", fontsize=11)
        return
    _image_panel(axes[0], view, _shaded(rig, view), f"{title}: {_camera_title(rig)}", "#101218")
    table = np.array([to_rgb(COLOURS[verdict]) for verdict in Verdict])
    share = 100 * (view.judged[view.on_object] == Verdict.ACCEPTED).mean()
    _image_panel(axes[1], view, table[view.judged], f"{title}: verdicts ({share:.0f} % accepted)")
    thresholds = levels(rig.config.peak_threshold)
    colours = np.array([to_rgb(colour) for colour in [NEVER, *threshold_colours(len(thresholds))]])
    survived = np.searchsorted(thresholds, np.nan_to_num(view.peak), side="right")
    image = colours[survived]
    image[~view.on_object] = 1
    _image_panel(axes[2], view, image, f"{title}: largest threshold survived")


def _camera_title(rig: Rig) -> str:
    return "rows over frames" if rig.passes else "camera and one stripe"


def _shaded(rig: Rig, view: SheetView) -> NDArray[np.float64]:
    """Colour of each hit: shaded by a lamp at the camera, and one stripe in red, (n, 3)."""
    hits, config = view.hits, rig.config_of(view.number)
    lamp = -np.einsum("nd,nd->n", hits.normals, hits.points) / np.linalg.norm(hits.points, axis=1)
    grey = 0.75 * np.clip(lamp, 0, 1)
    laser = stripe.laser_coordinates(hits.points, config.baseline)
    lit = hits.radiance > 0
    if rig.passes:  # every row of a frame is lit: no stripe to show
        lit[:] = False
    theta = float(np.median(laser.angle[lit])) if lit.any() else -np.pi / 2
    red = np.clip(hits.radiance, 0, 1) * stripe.light(theta - laser.angle[:, None], laser, config)[:, 0]
    return np.clip(np.stack([grey * (1 - red) + red, grey * (1 - red), grey * (1 - red)], axis=1), 0, 1)


def _image_panel(
    axes: "Axes", view: SheetView, values: NDArray[Any], title: str, ground: str = "#ffffff"
) -> None:
    """Show colours of hits, (n, 3), as an image that is cropped to the object."""
    from matplotlib.colors import to_rgb

    pixels = view.hits.pixels
    low, high = pixels[view.on_object].min(axis=0) - 6, pixels[view.on_object].max(axis=0) + 7
    image = np.empty((high[1] - low[1], high[0] - low[0], 3))
    image[:] = to_rgb(ground)
    inside = view.on_object
    image[pixels[inside, 1] - low[1], pixels[inside, 0] - low[0]] = values[inside]
    axes.imshow(image, extent=(low[0], high[0], high[1], low[1]), interpolation="nearest")
    axes.set_title(title, fontsize=9.5)
    axes.set_xticks([])
    axes.set_yticks([])


def share_panel(axes: "Axes", views: list[SheetView]) -> None:
    """Shares of the verdicts in every view as stacked bars, and over all views in the legend."""
    numbers = np.arange(len(views))
    base = np.zeros(len(views))
    everything = np.concatenate([view.judged[view.on_object] for view in views])
    for verdict in list(Verdict)[1:]:
        share = [100 * (v.judged[v.on_object] == verdict).sum() / max(v.on_object.sum(), 1) for v in views]
        if any(share):
            mean = 100 * float((everything == verdict).mean())
            label = f"{verdict_name(verdict)} {mean:.1f} %"
            axes.bar(numbers, share, bottom=base, color=COLOURS[verdict], label=label, width=0.8)
        base += share
    axes.set_title("what became of the pixels that see the object", fontsize=11)
    axes.set_xlabel("view")
    axes.set_xticks(numbers[:: max(1, len(numbers) // 10)])
    axes.set_ylabel("% of the pixels of the view")
    axes.set_ylim(0, 100)
    axes.set_xlim(-0.6, len(views) - 0.4)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(
        loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3, fontsize=8.5, frameon=False,
        title="over all views", title_fontsize=8.5,
    )  # fmt: skip


def threshold_panel(axes: "Axes", views: list[SheetView], config: ScannerConfig) -> None:
    """Accepted share at each threshold and what the step to it drops, in the colours of the maps."""
    thresholds = levels(config.peak_threshold)
    shares = 100 * accepted_shares(views, thresholds)
    colours = threshold_colours(len(thresholds))
    last = np.append(shares[1:], 0)
    for k, (share, left) in enumerate(zip(shares, last, strict=True)):
        axes.bar(k, left, color=NEVER, width=0.8)
        axes.bar(k, share - left, bottom=left, color=colours[k], width=0.8)
        axes.text(k, share + 1.5, f"{share:.1f}", ha="center", fontsize=9)
    axes.set_title("accepted at each peak threshold; in colour: dropped by the next", fontsize=11)
    axes.set_xticks(range(len(thresholds)), [f"{threshold:g}" for threshold in thresholds])
    axes.set_xlabel("peak threshold, relative to a white surface that faces the laser")
    axes.set_ylabel("% of the pixels that see the object, all views")
    axes.set_ylim(0, 108)
    axes.spines[["top", "right"]].set_visible(False)
    _threshold_legend(axes, thresholds, colours)


def _threshold_legend(axes: "Axes", thresholds: list[float], colours: list[Any]) -> None:
    """What the colours of bars and maps mean."""
    from matplotlib.patches import Patch

    handles = [Patch(color=NEVER, label="never accepted (maps)")]
    handles += [
        Patch(color=colour, label=f"survives {low:g}, not {high:g}")
        for colour, low, high in zip(colours, thresholds, thresholds[1:], strict=False)
    ]
    handles.append(Patch(color=colours[-1], label=f"survives {thresholds[-1]:g}"))
    axes.legend(
        handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3, fontsize=8.5, frameon=False
    )


def rig_panel(axes: Any, rig: Rig, view: int) -> None:
    """Draw the object, all cameras, and camera, laser and swept frustum of one view; up is up."""
    config = rig.config_of(view)
    upward = "xyz".index(config.up)
    order = [(upward + 1) % 3, (upward + 2) % 3, upward]
    pose = rig.poses[view]

    def line(points: NDArray[np.float64], **style: Any) -> None:
        axes.plot(*points[:, order].T, **style)

    step = max(1, len(rig.tracer.vertices) // 3000)
    axes.scatter(*rig.tracer.vertices[::step, order].T, s=2, c="#6f7780", alpha=0.7, linewidths=0)
    eyes = rig.poses[:, :3, 3]
    axes.scatter(*eyes[:, order].T, c="#9db4d0", s=14)
    for number, eye in enumerate(eyes[:30, order]):
        axes.text(*eye, f" {number}", fontsize=7, color="#1d4e89")
    laser = pose[:3, 3] + config.baseline * pose[:3, 0]
    axes.scatter(*pose[:3, 3][order], c="#1d4e89", s=45, label=f"camera {view}, its field solid")
    axes.scatter(*laser[order], c="#d1495b", s=45, label="its laser, sweep dashed")
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
    axes.set_title("the rig in mm", fontsize=11)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.06), fontsize=8.5, frameon=False)
    axes.set_aspect("equal")
    spans = [float(np.ptp(limits)) for limits in (axes.get_xlim(), axes.get_ylim(), axes.get_zlim())]
    axes.set_box_aspect(spans, zoom=RIG_ZOOM)  # cameras stand far away: without it the object is tiny
    axes.tick_params(labelsize=7)

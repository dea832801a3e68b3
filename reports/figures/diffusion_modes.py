"""A diffusion: the medial centres of its points, and an eigenfunction as colours on the cloud."""

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from datasets_gen.records import InputError
from datasets_gen.values import check_count
from medial.diffusion import Diffusion
from reports.figures.cloud_drawing import caption, place_cloud, position_colors
from reports.figures.point_renderer import best_azimuth, fitted_cameras, look_from
from reports.figures.style import HEADROOM, blank, new_figure, styled

SIGNED = LinearSegmentedColormap.from_list("signed", ["#0072b2", "#f1eef0", "#d55e00"])
"""Blue for negative values, orange for positive ones."""


@styled
def diffusion_modes(diffusion: Diffusion, mode: int = 1, height: int = 480, up: int = 1) -> Figure:
    """The cloud and its medial centres (Eq. 9) in colours of the centres' positions, and an eigenfunction.

    Parameters
    ----------
    diffusion
        Of a surface operator, which has no medial centres, the eigenfunction alone is drawn.
    mode
        Number of the eigenfunction; 0 is constant.
    height
        Pixels of the cloud.
    up
        Axis that points upwards.

    Raises
    ------
    InputError
        If there is no such eigenfunction.
    """
    if check_count(mode, "mode", 0) >= len(diffusion.eigenvalues):
        raise InputError(f"no mode {mode!r}; give a number from 0 to {len(diffusion.eigenvalues) - 1}")
    values = diffusion.eigenfunctions[:, mode]
    signed = SIGNED(0.5 + 0.5 * values / max(np.quantile(np.abs(values), 0.99), 1e-300))[:, :3]
    note = f"eigenvalue {diffusion.eigenvalues[mode]:.4g}, {diffusion.operator}"
    shown = [(f"mode {mode}", note, diffusion.points, diffusion.normals, signed)]
    rotation = look_from(best_azimuth(diffusion.points, up), up=up)
    if diffusion.operator == "medial":
        low, high = np.quantile(diffusion.centers, [0.01, 0.99], axis=0)
        colors = position_colors(diffusion.centers, low, high)
        facing = np.tile(rotation[2], (len(diffusion), 1))  # centres have no side
        cloud = ("cloud", "coloured by medial centre", diffusion.points, diffusion.normals, colors)
        shown = [cloud, ("medial centres", "Eq. 9", diffusion.centers, facing, colors), *shown]
    return _side_by_side(shown, diffusion.points, rotation, height)


def _side_by_side(
    shown: list[tuple[str, str, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]],
    points: NDArray[np.float64],
    rotation: NDArray[np.float64],
    height: int,
) -> Figure:
    """Clouds (title, note, points, normals, colours) through one camera, which fits `points`."""
    camera = fitted_cameras([points], rotation, height)[0]
    wide = max(3.0 * camera.width / height, 1.6)
    figure, grid = new_figure(1, len(shown), wide * len(shown) + 0.2, 3.6, HEADROOM)
    for axes, (title, note, cloud, normals, colors) in zip(grid[0], shown, strict=True):
        blank(axes)
        place_cloud(axes, cloud, normals, colors, camera)
        caption(axes, title, note)
    return figure

"""From where the two clouds of a map are seen."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from reports.figures.cloud_drawing import DrawnCloud
from reports.figures.point_renderer import (
    Camera,
    best_azimuth,
    fitted_cameras,
    look_from,
    seen_from_behind,
)

Float = NDArray[np.float64]

TURNED = ", turned by 180°"
"""Said in the title of a target that is seen from the side opposite to that of the source."""


@dataclass(frozen=True)
class PairCameras:
    """Cameras of two clouds, of one scale and one size.

    Attributes
    ----------
    source, target : Camera
    behind : bool
        The target is seen from the other side than the source.
    """

    source: Camera
    target: Camera
    behind: bool

    @property
    def words(self) -> str:
        """What the title of the target ends with."""
        return TURNED if self.behind else ""


def pair_cameras(source: DrawnCloud, target: DrawnCloud, up: int, height: int) -> PairCameras:
    """Cameras that show the widest side of the source, and the target from the same direction.

    A scan is one-sided: where the source would show its inner side, both are seen from the other side, and
    where the target then shows its own, it alone is turned by half a turn about the vertical axis.

    Parameters
    ----------
    source, target
    up
        Axis that points upwards.
    height
        Pixels of the taller cloud.
    """
    azimuth = best_azimuth(source.points, up)
    if seen_from_behind(source.normals, look_from(azimuth, up=up)[2]):
        azimuth += 180.0
    (here, _), (there, behind) = outside_cameras(
        [(each.points, each.normals) for each in (source, target)], azimuth, up, height
    )
    return PairCameras(here, there, behind)


def outside_cameras(
    clouds: Sequence[tuple[Float, Float]], azimuth: float, up: int, height: int
) -> list[tuple[Camera, bool]]:
    """Cameras of one scale and size that show clouds from one direction, or from behind.

    Those that would show their inner side are turned by half a turn about the vertical axis.

    Parameters
    ----------
    clouds
        Points and normals of each, (n, 3).
    azimuth
        Of the direction, in degrees.
    up
        Axis that points upwards.
    height
        Pixels of the tallest cloud.

    Returns
    -------
    list of (Camera, bool)
        Of each cloud, and whether it is seen from behind.
    """
    towards = look_from(azimuth, up=up)[2]
    behind = [seen_from_behind(normals, towards) for _, normals in clouds]
    rotations = np.array([look_from(azimuth + 180.0 * turned, up=up) for turned in behind])
    cameras = fitted_cameras([points for points, _ in clouds], rotations, height)
    width = max(camera.width for camera in cameras)
    return [(replace(camera, width=width), turned) for camera, turned in zip(cameras, behind, strict=True)]

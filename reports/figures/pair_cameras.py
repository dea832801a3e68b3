"""From where the two clouds of a map are seen."""

from dataclasses import dataclass, replace

import numpy as np

from reports.figures.cloud_drawing import DrawnCloud
from reports.figures.point_renderer import (
    Camera,
    best_azimuth,
    fitted_cameras,
    look_from,
    seen_from_behind,
)

FROM_BEHIND = ", from behind"
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
        return FROM_BEHIND if self.behind else ""


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
    behind = seen_from_behind(target.normals, look_from(azimuth, up=up)[2])
    rotations = np.array([look_from(a, up=up) for a in (azimuth, azimuth + 180.0 * behind)])
    cameras = fitted_cameras([source.points, target.points], rotations, height)
    width = max(camera.width for camera in cameras)
    here, there = (replace(camera, width=width) for camera in cameras)
    return PairCameras(here, there, behind)

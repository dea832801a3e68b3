"""Triangulation: a pixel's camera ray meets the plane of the laser sheet that lit it."""

import numpy as np
from numpy.typing import NDArray


def triangulate(
    rays: NDArray[np.float64], angle: NDArray[np.float64], baseline: float
) -> NDArray[np.float64]:
    """Intersect camera rays with planes of the laser sheet.

    Parameters
    ----------
    rays : (n, 3)
        Directions from the camera with depth 1.
    angle : (n,)
        Sheet angles, radians: 0 along the viewing direction, positive to the right.
    baseline
        Of the laser along camera x.

    Returns
    -------
    (n, 3) float64
        Points in camera coordinates, in the units of the baseline; not finite where a ray is parallel to its
        plane.
    """
    slope = np.tan(angle)  # the plane x = baseline + slope z
    return rays * (baseline / (rays[:, 0] - slope))[:, None]

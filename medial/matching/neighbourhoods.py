"""What lies together on a body: near in the diffusion map, and near in space."""

import numpy as np
from numpy.typing import NDArray

from medial.diffusion import Diffusion
from medial.matching.landmarks.samples import diffusion_map, farthest_points, smallest_time
from medial.matching.nearest import nearest

Float32 = NDArray[np.float32]

NEAR = 3.0
"""Diffusion time of the map, in smallest times 4 ln 10 / lambda_max."""
TELLING = 1e-3
"""Relative range of a diffusion map below which it tells no points apart."""
RESOLVED = 1e-4
"""Modes that decayed to less than this, relative to the largest, change no distance in single precision."""
PIECES = 80
"""Pieces that the cloud is cut into to find the unit of each kind of nearness."""


def neighbourhoods(diffusion: Diffusion) -> Float32:
    """Coordinates in which points of one piece of a limb are close, (n, modes + 3) or (n, 3).

    The diffusion map keeps limbs apart that come close in space. But where the surface between two limbs is
    missing, an empty ball may span both, and diffusion takes them for one: positions keep these apart. Each
    counts in units of the typical radius of a piece. All of a ball is one medial region: where diffusion
    tells nothing apart, nearness in space has to do.
    """
    diffused = diffusion_map(diffusion, NEAR * smallest_time(diffusion)).astype(np.float32)
    largest = np.abs(diffused).max(axis=0)
    diffused = np.ascontiguousarray(diffused[:, largest > RESOLVED * largest.max()])
    space = (diffusion.points - diffusion.points.mean(axis=0)).astype(np.float32)
    space /= piece_radius(space)
    if np.ptp(diffused, axis=0).max() < TELLING * np.abs(diffused).max():
        return space
    return np.hstack([diffused / piece_radius(diffused), space])


def piece_radius(coordinates: Float32) -> float:
    """Median distance of the points (n, d) from the nearest of some points far apart."""
    remote = int((coordinates**2).sum(axis=1).argmax())
    count = min(PIECES, max(len(coordinates) // 4, 1))
    centres = coordinates[farthest_points(coordinates, count, remote)]
    radius = float(np.median(nearest(coordinates, centres)[1]))
    return radius if radius > 0 else 1.0

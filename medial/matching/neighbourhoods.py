"""Coordinates that group points by body part: near in the diffusion map, and near in space."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.points.farthest import farthest_in_embedding
from medial.diffusion import Diffusion
from medial.matching.landmarks.samples import diffusion_map
from medial.matching.nearest import nearest
from medial.spectrum.times import shortest_time

Float32 = NDArray[np.float32]

TIME = 3.0
"""Diffusion time of the map, in shortest times 4 ln 10 / lambda_max."""
LEAST_RANGE = 1e-3
"""Range of the diffusion map, relative to its largest coordinate, below which it tells no points apart."""
LEAST_MODE = 1e-4
"""Modes that decayed to less than this, relative to the largest, change no distance in single precision."""
PIECES = 80
"""Pieces that the cloud is cut into to find the unit of each part of the coordinates."""


def neighbourhoods(diffusion: Diffusion) -> Float32:
    """Coordinates in which points of one piece of a limb are close: diffusion map and positions together.

    The diffusion map keeps limbs apart that come close in space. But where the surface between two limbs is
    missing, an empty ball may span both, and diffusion takes them for one: positions keep these apart. Each
    part is divided by the typical radius of a piece in it.

    Parameters
    ----------
    diffusion

    Returns
    -------
    (n, modes + 3) float32, without unit
        (n, 3) where the diffusion map tells no points apart: all of a ball is one medial region.
    """
    time = TIME * shortest_time(diffusion.eigenvalues)
    diffused = diffusion_map(diffusion, time).astype(np.float32)
    largest = np.abs(diffused).max(axis=0)
    diffused = np.ascontiguousarray(diffused[:, largest > LEAST_MODE * largest.max()])
    space = (diffusion.points - diffusion.points.mean(axis=0)).astype(np.float32)
    space /= piece_radius(space)
    if np.ptp(diffused, axis=0).max() < LEAST_RANGE * np.abs(diffused).max():
        return space
    return np.hstack([diffused / piece_radius(diffused), space])


def piece_radius(coordinates: Float32) -> float:
    """Median distance of points (n, d) from the nearest of `PIECES` farthest points; 1 if that is 0."""
    remote = int((coordinates**2).sum(axis=1).argmax())
    count = min(PIECES, max(len(coordinates) // 4, 1))
    centres = coordinates[farthest_in_embedding(coordinates, count, remote)]
    radius = float(np.median(nearest(coordinates, centres)[1]))
    return radius if radius > 0 else 1.0

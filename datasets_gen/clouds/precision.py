"""Whether rounding has eaten the detail of a cloud: steps of coordinates against distances of points.

Single precision has seven digits. Coordinates of a map, as 500,000 east and 5,400,000 north, have then steps
of 3 cm and of half a metre: a person is a few layers of points, and planes through neighbours are the layers.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from datasets_gen.clouds.point_cloud import Array

COARSE = 0.5
"""Step of the coordinates, over the distance of neighbours, from which it is worth saying: on a person of
20,000 points the share of estimated normals on the right side falls from .975 to .97 at twice this."""
FEWEST_STEPS = 50
"""Steps along the diagonal below which normals cannot be estimated: a quarter of them point inward there."""
FINE = 1e-5
"""Steps below this share of the extent are not looked at."""
MOST_DECIMALS = 6
PROBES = 5000


@dataclass(frozen=True)
class Rounding:
    """How finely coordinates are given.

    Attributes
    ----------
    steps : (3,) float64
        Smallest difference of coordinates along each axis; 0 where it is finer than matters.
    single : bool
        All coordinates fit into single precision, which is then what rounds them.
    apart : float
        Median distance from a point to the nearest one at another place; 0 where steps do not matter.
    across : float
        How often the coarsest step fits into the diagonal; infinite where steps do not matter.
    """

    steps: Array
    single: bool
    apart: float
    across: float

    @property
    def coarse(self) -> bool:
        """Whether detail of the size of the points' distances is lost."""
        return bool(self.steps.max() > COARSE * self.apart)

    @property
    def hopeless(self) -> bool:
        """Whether single precision has left too little to tell a surface."""
        return self.single and self.across < FEWEST_STEPS

    def words(self) -> str:
        """What is worth saying, in one line; empty where nothing is."""
        if not self.coarse:
            return ""
        axis = int(self.steps.argmax())
        how = "stored in single precision, far from the origin" if self.single else "rounded"
        return (
            f"coordinates are {how}: {'xyz'[axis]} has steps of {self.steps[axis]:.3g} where points are "
            f"{self.apart:.3g} apart, {self.across:.0f} steps across the cloud; subtract the offset in "
            "double precision before writing, or write more digits"
        )


def rounding_of(points: Array) -> Rounding:
    """How finely the coordinates of points (n, 3), finite, are given; a tenth of them may lie far away."""
    fine = Rounding(np.zeros(3), False, 0.0, np.inf)
    if len(points) < 2:
        return fine
    with np.errstate(over="ignore"):
        single = bool((points.astype(np.float32) == points).all())
    low, high = np.quantile(points, [0.05, 0.95], axis=0)
    extent = float(np.linalg.norm(high - low)) / 0.9
    size = np.quantile(np.abs(points), 0.9, axis=0).astype(np.float32)
    steps = np.spacing(size).astype(np.float64) if single else _decimal_steps(points)
    steps = np.where(np.ptp(points, axis=0) > 0, steps, 0.0)  # where nothing varies there is no detail
    if not extent > 0 or not np.isfinite(extent) or steps.max() < FINE * extent:
        return fine
    return Rounding(steps, single, spacing(points), extent / float(steps.max()))


def _decimal_steps(points: Array) -> Array:
    """Step of each axis by the number of decimals that its coordinates have; 0 for many."""
    out = np.zeros(3)
    for axis in range(3):
        values = points[:, axis]
        for decimals in range(MOST_DECIMALS + 1):
            if (np.round(values, decimals) == values).all():
                out[axis] = 10.0**-decimals
                break
    return out


def spacing(points: Array) -> float:
    """Median distance from a point to the nearest one at another place, of points spread over the list."""
    places = np.unique(points, axis=0)
    if len(places) < 2:
        return 0.0
    probes = places[:: max(1, len(places) // PROBES)]
    return float(np.median(cKDTree(places).query(probes, k=2)[0][:, 1]))

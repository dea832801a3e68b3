"""From where a scan was seen, and which surface it would therefore show: estimated from the cloud alone.

Where a scan could not have seen the counterpart of a point, its absence says nothing; where it should have,
it says that the map is wrong. Two scans from opposite sides share hardly any surface under the right map, and
most of it after half a turn about the body's long axis: without visibility the wrong map looks better.

A direction is one from which the scan was seen if points face it and nothing of the cloud is in front of them
[KTB07 decide the same by hidden point removal]. Few directions are chosen, each the one that explains most of
what is left; then each turns to the mean normal of the points that it explains best.

References
----------
[KTB07] Katz, Tal, Basri: Direct visibility of point sets. SIGGRAPH 2007.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter
from scipy.spatial import cKDTree

from datasets_gen.compiled import compiled
from datasets_gen.points.fibonacci import fibonacci_sphere

Float = NDArray[np.float64]

DIRECTIONS = 200
"""Directions that are tried, even on the sphere."""
MOST = 12
"""At most so many are chosen."""
GAIN = 0.03
"""Mean gain in cosine between normals and the nearest direction from which one more is chosen."""
TURNS = 4
"""Rounds in which the directions turn."""
FEWEST = 20
"""Directions that explain fewer points stay."""
GRAZING = 0.15
"""Cosine between normal and direction below which a point is not seen."""
SELDOM = 10.0
"""Percentile of the cosines of seen points that counts as the least cosine that the scanner accepts."""
SOFT = 0.1
"""Cosines about the least one within which it is open whether a point is seen."""
CELL = 2.0
"""Width of a cell of the depth maps, in typical distances between neighbours."""
FINEST = 1000
"""Cells of a depth map are no smaller than the cloud's extent / this."""
BEHIND = 4.0
"""What lies deeper than the nearest point of its cell by more of these distances is hidden."""
ONE_SIDE = 0.98
"""Share of a cloud that one direction sees if the cloud was seen from one side."""
OWN_CELL = 1.5
"""As `CELL`, for what hides points of the cloud itself: in wider cells they would hide each other."""
STEEPEST = 4.0
"""Limit of 1 / cosine up to which a steeper surface may lie deeper than the nearest point of its cell."""


@dataclass(frozen=True)
class DepthMap:
    """Depth of a cloud's nearest points in cells square to a direction.

    Attributes
    ----------
    toward : (3,) float64
        Unit vector to the viewer, who is far away.
    axes : (3, 2) float64
        Of the image.
    corner : (2,) float64
        Of the first cell.
    cell, margin : float
        Width of a cell, and how much deeper than the nearest point of the cell counts as hidden.
    depth : (rows, columns) float64
        Infinite where nothing is near.
    """

    toward: Float
    axes: Float
    corner: Float
    cell: float
    margin: float
    depth: Float

    @classmethod
    def of(
        cls, points: Float, toward: Float, spacing: float, width: float = CELL, around: int = 3
    ) -> "DepthMap":
        """Depth map of points (n, 3), in cells of `width` spacings.

        A cell holds the nearest point of its neighbours as well, of the square of `around` cells about it.
        """
        side = np.cross(toward, np.eye(3)[np.abs(toward).argmin()])
        side /= np.linalg.norm(side)
        axes = np.stack([side, np.cross(toward, side)], axis=1)
        cell = width * spacing
        image = points @ axes
        corner = image.min(axis=0) - 2 * cell
        place = np.floor((image - corner) / cell).astype(np.int64)
        depth = np.full(tuple(place.max(axis=0) + 3), np.inf)
        np.minimum.at(depth, (place[:, 0], place[:, 1]), -(points @ toward))
        return cls(toward, axes, corner, cell, BEHIND * spacing, minimum_filter(depth, around))

    def free(self, points: Float, slack: Float | float = 1.0) -> NDArray[np.bool_]:
        """Whether nothing of the cloud lies between points (n, 3) and the viewer, with `slack` margins.

        Surface steeper than some 45 degrees to the direction is hidden by its own neighbours: no scan is
        expected to show it.
        """
        behind = np.zeros(len(points)) + slack * self.margin
        image = self.axes, self.corner, self.cell, self.depth
        return np.asarray(_nothing_before(points, self.toward, *image, behind))


@compiled()
def _nothing_before(
    points: Float, toward: Float, axes: Float, corner: Float, cell: float, depth: Float, behind: Float
) -> NDArray[np.bool_]:
    """Whether each point is no more than `behind` (n,) deeper than its cell of a depth map, (n,)."""
    free = np.ones(len(points), np.bool_)
    rows, columns = depth.shape
    for i in range(len(points)):
        x, y, z = points[i]
        row = np.floor((x * axes[0, 0] + y * axes[1, 0] + z * axes[2, 0] - corner[0]) / cell)
        column = np.floor((x * axes[0, 1] + y * axes[1, 1] + z * axes[2, 1] - corner[1]) / cell)
        if 0 <= row < rows and 0 <= column < columns:
            own = -(x * toward[0] + y * toward[1] + z * toward[2])
            free[i] = own <= depth[int(row), int(column)] + behind[i]
    return free


@dataclass(frozen=True)
class Visibility:
    """Directions from which a cloud was seen.

    Attributes
    ----------
    maps : tuple of DepthMap
        One per direction.
    least : float
        Least cosine between normal and direction at which the scanner accepted points.
    """

    maps: tuple[DepthMap, ...]
    least: float

    @classmethod
    def of(cls, points: Float, normals: Float) -> "Visibility":
        """Estimate from where a cloud was seen.

        Parameters
        ----------
        points, normals : (n, 3)
            Normals are unit and outward.
        """
        spacing = typical_spacing(points)
        if spacing == 0:
            return cls((), 1.0)
        maps = [DepthMap.of(points, toward, spacing) for toward in fibonacci_sphere(DIRECTIONS)]
        worth = _seen(points, normals, maps)
        maps = [maps[k] for k in _explaining(worth)]
        for _ in range(TURNS if maps else 0):
            worth = _seen(points, normals, maps)
            own = np.where(worth.max(axis=0) > 0, worth.argmax(axis=0), -1)
            groups = [normals[own == k] for k in range(len(maps))]
            toward = [
                g.mean(axis=0) if len(g) > FEWEST else m.toward for g, m in zip(groups, maps, strict=True)
            ]
            maps = [DepthMap.of(points, each / np.linalg.norm(each), spacing) for each in toward]
        best = _seen(points, normals, maps).max(axis=0, initial=0.0)
        least = float(np.percentile(best[best > 0], SELDOM)) if (best > 0).any() else 1.0
        return cls(tuple(maps), least)

    def expected(self, points: Float, normals: Float) -> Float:
        """How surely the scan would show surface there, in [0, 1].

        Parameters
        ----------
        points, normals : (n, 3)
        """
        expected = np.zeros(len(points))
        for each in self.maps:
            facing = np.clip((normals @ each.toward - self.least) / (2 * SOFT) + 0.5, 0, 1)
            expected = np.maximum(expected, facing * each.free(points))
        return expected


def from_one_side(points: Float, normals: Float) -> bool:
    """Whether a cloud may have been seen from one side: some direction sees `ONE_SIDE` of it.

    Parameters
    ----------
    points, normals : (n, 3)
        Normals are unit and outward.
    """
    spacing = typical_spacing(points)
    for toward in fibonacci_sphere(DIRECTIONS) if spacing > 0 else ():
        cosine = normals @ toward
        if (cosine > 0).mean() >= ONE_SIDE:
            inverse = 1 / np.clip(cosine, 1 / STEEPEST, 1)
            slack = np.maximum(1.0, np.sqrt(inverse**2 - 1))  # tangent of the surface's slope
            free = DepthMap.of(points, toward, spacing, OWN_CELL, 1).free(points, slack)
            if ((cosine > 0) & free).mean() >= ONE_SIDE:
                return True
    return False


def typical_spacing(points: Float) -> float:
    """Median distance between nearest neighbours, at least extent / `FINEST`; 0 if all points are one.

    Repeated points do not count: where most of a cloud is doubled, the median of all would be 0.
    """
    nearest = cKDTree(points).query(points, k=2)[0][:, 1]
    apart = nearest[nearest > 0]
    if len(apart) == 0:
        apart = cKDTree(distinct := np.unique(points, axis=0)).query(distinct, k=2)[0][:, 1]
    extent = float(np.ptp(points, axis=0).max())
    return max(float(np.median(apart)), extent / FINEST) if extent > 0 else 0.0


def _seen(points: Float, normals: Float, maps: list[DepthMap]) -> Float:
    """Cosine between each point's normal and each direction; 0 where it is not seen, (d, n)."""
    cosine = np.array([normals @ each.toward for each in maps]).reshape(len(maps), len(points))
    free = np.array([each.free(points) for each in maps], dtype=bool).reshape(cosine.shape)
    return np.where((cosine > GRAZING) & free, cosine, 0.0)


def _explaining(worth: Float) -> list[int]:
    """Directions (rows of (d, n)), each the one that adds most to the best cosines of the points."""
    chosen: list[int] = []
    best = np.zeros(worth.shape[1])
    while len(chosen) < MOST:
        gain = np.maximum(worth - best, 0).mean(axis=1)
        if gain.max() < GAIN:
            break
        chosen.append(int(gain.argmax()))
        best = np.maximum(best, worth[chosen[-1]])
    return chosen

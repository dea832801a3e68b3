"""Smooth implicit surfaces: swept profiles and ellipsoids joined by a smooth minimum."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

Array = NDArray[np.float64]

PROFILE_SAMPLES = 65


def smooth_min(a: Array, b: Array, blend: float) -> Array:
    """Polynomial smooth minimum, equal to min(a, b) where they differ by more than `blend` (length)."""
    gap = np.maximum(blend - np.abs(a - b), 0.0) / blend
    return np.minimum(a, b) - gap * gap * blend / 4


def unit(vector: ArrayLike) -> Array:
    """The vector divided by its length."""
    v = np.asarray(vector, dtype=np.float64)
    return v / np.linalg.norm(v)


def frame(axis: ArrayLike, front: ArrayLike) -> Array:
    """Rows (side, axis, front): an orthonormal frame about `axis` whose last row leans towards `front`."""
    along = unit(axis)
    forward = np.asarray(front, dtype=np.float64)
    forward = unit(forward - (forward @ along) * along)
    return np.stack([np.cross(along, forward), along, forward])


def radial_distance(scaled: Array, radii: Array) -> Array:
    """First-order distance to the unit sphere of coordinates divided by `radii`: k (k - 1) / |grad|.

    With k the norm of the scaled coordinates, exact for a sphere and correct to first order near the
    surface of an ellipsoid.

    Parameters
    ----------
    scaled : (n, 3)
        Coordinates divided by the radii.
    radii : (n, 3) or (3,)

    Returns
    -------
    (n,)
    """
    k = np.linalg.norm(scaled, axis=1)
    slope = np.linalg.norm(scaled / radii, axis=1)
    centre = slope < 1e-12
    return np.where(centre, -np.min(radii, axis=-1), k * (k - 1) / np.where(centre, 1.0, slope))


@dataclass(frozen=True, kw_only=True)
class Ellipsoid:
    """An ellipsoid.

    Attributes
    ----------
    bones : tuple of str
        Bones that carry it; each vertex goes with the nearest of them.
    center : (3,)
    radii : (3,)
        Along the rows of `axes`.
    axes : (3, 3)
        Orthonormal rows.
    blend : float
        Width of the smooth join with what was placed before it.
    carve : bool
        Subtract it instead.
    """

    bones: tuple[str, ...]
    center: Array
    radii: Array
    axes: Array = field(default_factory=lambda: np.eye(3))
    blend: float = 0.02
    carve: bool = False

    def distance(self, points: Array) -> Array:
        """Approximate signed distance of points (n, 3), negative inside."""
        return radial_distance((points - self.center) @ self.axes.T / self.radii, self.radii)

    def bounds(self) -> Array:
        """Lower and upper corner of the bounding box, (2, 3)."""
        reach = np.linalg.norm(self.axes * self.radii[:, None], axis=0)
        return np.stack([self.center - reach, self.center + reach])


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """A straight axis with elliptical cross-sections that change along it, and rounded ends.

    Attributes
    ----------
    bones : tuple of str
        Bones that carry it; each vertex goes with the nearest of them.
    start, end : (3,)
        Ends of the axis.
    front : (3,)
        Direction of the depth of the cross-sections.
    profile : (s, 5)
        Rows (position along the axis in [0, 1], half width, half depth, shift to the side, shift to the front).
    caps : (2,)
        Length by which the rounded ends reach beyond start and end.
    blend : float
        Width of the smooth join with what was placed before it.
    """

    bones: tuple[str, ...]
    start: Array
    end: Array
    front: Array
    profile: Array
    caps: tuple[float, float]
    blend: float = 0.02
    carve: bool = False

    def distance(self, points: Array) -> Array:
        """Approximate signed distance of points (n, 3), negative inside."""
        length = float(np.linalg.norm(self.end - self.start))
        side, along, forward = ((points - self.start) @ frame(self.end - self.start, self.front).T).T
        stations = np.linspace(0, 1, PROFILE_SAMPLES)
        table = PchipInterpolator(self.profile[:, 0], self.profile[:, 1:])(stations)
        at = np.clip(along / length, 0, 1)
        width, depth, shift, lift = (np.interp(at, stations, column) for column in table.T)
        beyond = along - at * length
        cap = np.where(beyond < 0, self.caps[0], self.caps[1])
        radii = np.stack([width, cap, depth], axis=1)
        return radial_distance(np.stack([side - shift, beyond, forward - lift], axis=1) / radii, radii)

    def bounds(self) -> Array:
        """Lower and upper corner of the bounding box, (2, 3)."""
        reach = float(np.max(np.abs(self.profile[:, 1:3]) + np.abs(self.profile[:, 3:5])) + max(self.caps))
        ends = np.stack([self.start, self.end])
        return np.stack([ends.min(axis=0) - reach, ends.max(axis=0) + reach])


Part = Ellipsoid | Sweep


@dataclass(frozen=True)
class Body:
    """Parts joined in order by smooth minima (and carved by smooth maxima): negative inside.

    Attributes
    ----------
    parts : tuple of Part
    """

    parts: tuple[Part, ...]

    def __call__(self, points: Array, far: float = 1.0) -> Array:
        """Field at points (n, 3): near the surface the signed distance to first order, at most `far`."""
        value = np.full(len(points), far)
        for part in self.parts:
            lower, upper = part.bounds()
            margin = part.blend + 0.02
            near = ((points > lower - margin) & (points < upper + margin)).all(axis=1)
            value[near] = self._join(value[near], part, points[near])
        return value

    def gradient(self, points: Array, step: float = 5e-4) -> Array:
        """Gradient by central differences, (n, 3)."""
        shifts = step * np.concatenate([np.eye(3), -np.eye(3)])
        values = self((points[None] + shifts[:, None]).reshape(-1, 3)).reshape(6, -1)
        return ((values[:3] - values[3:]) / (2 * step)).T

    def on_grid(self, origin: Array, spacing: float, shape: tuple[int, int, int], far: float = 1.0) -> NDArray:
        """Field on a regular grid, each part only in its own box, as float32 of the given shape."""
        value = np.full(shape, far, dtype=np.float32)
        for part in self.parts:
            margin = part.blend + 2 * spacing
            lower, upper = (part.bounds() + [[-margin], [margin]] - origin) / spacing
            first = np.clip(np.floor(lower).astype(int), 0, shape)
            last = np.clip(np.ceil(upper).astype(int) + 1, 0, shape)
            if (last <= first).any():
                continue
            box = tuple(slice(a, b) for a, b in zip(first, last, strict=True))
            axes = [origin[k] + spacing * np.arange(first[k], last[k]) for k in range(3)]
            points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
            part_of = value[box]
            value[box] = self._join(part_of.ravel().astype(np.float64), part, points).reshape(part_of.shape)
        return value

    def bounds(self) -> Array:
        """Lower and upper corner of the bounding box, (2, 3)."""
        boxes = np.stack([part.bounds() for part in self.parts if not part.carve])
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])

    @staticmethod
    def _join(value: Array, part: Part, points: Array) -> Array:
        distance = part.distance(points)
        if part.carve:
            return -smooth_min(-value, distance, part.blend)
        return smooth_min(value, distance, part.blend)

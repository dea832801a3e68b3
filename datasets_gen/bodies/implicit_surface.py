"""Smooth implicit surfaces: swept cross-sections joined by smooth minima."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from datasets_gen.compiled import compiled

Array = NDArray[np.float64]

STATIONS = 65  # samples of a profile along its axis
MARGIN = 0.02  # around a part's box, beyond its blend, in which it is evaluated (metres)
INSIDE = -1.0  # distance given at the axis itself, where the direction to the surface is undefined


def unit(vector: ArrayLike) -> Array:
    """The vector divided by its length."""
    v = np.asarray(vector, dtype=np.float64)
    return v / np.linalg.norm(v)


def part_axes(axis: ArrayLike, front: ArrayLike) -> Array:
    """Rows (side, axis, front): an orthonormal frame about `axis` whose last row leans towards `front`."""
    along = unit(axis)
    forward = np.asarray(front, dtype=np.float64)
    forward = unit(forward - (forward @ along) * along)
    return np.stack([np.cross(along, forward), along, forward])


@dataclass(frozen=True, kw_only=True)
class Part:
    """A straight axis with super-elliptical cross-sections that change along it, and rounded ends.

    Attributes
    ----------
    bones : tuple of str
        Bones that carry it; each vertex goes with the nearest of them.
    start : (3,)
        Start of the axis.
    axes : (3, 3)
        Orthonormal rows: side, along the axis, front.
    length : float
        Of the axis; 0 makes an ellipsoid.
    profile : (s, 5)
        Rows (position along the axis in [0, 1], half width, half depth, shift to the side, shift to the
        front), interpolated monotonically.
    caps : (float, float)
        Lengths by which the rounded ends reach beyond start and end.
    blend : float
        Width of the smooth join with what was placed before.
    power : float
        Exponent of the cross-sections: 2 is an ellipse, more is squarer.
    carve : bool
        Subtract the part instead.
    """

    bones: tuple[str, ...]
    start: Array
    axes: Array
    length: float
    profile: Array
    caps: tuple[float, float]
    blend: float
    power: float = 2.0
    carve: bool = False

    @cached_property
    def table(self) -> Array:
        """Half width, half depth, shift and lift at equal steps along the axis, (STATIONS, 4)."""
        if len(self.profile) == 1:
            return np.repeat(self.profile[:, 1:], STATIONS, axis=0)
        from scipy.interpolate import PchipInterpolator  # imports scipy.optimize: a sixth of a second

        return PchipInterpolator(self.profile[:, 0], self.profile[:, 1:])(np.linspace(0, 1, STATIONS))

    def bounds(self) -> Array:
        """Lower and upper corner of a bounding box, (2, 3)."""
        width, depth, shift, lift = self.table.T
        lower = np.array([(shift - width).min(), -self.caps[0], (lift - depth).min()])
        upper = np.array([(shift + width).max(), self.length + self.caps[1], (lift + depth).max()])
        reach = np.abs(self.axes).T @ (upper - lower) / 2
        middle = self.start + (lower + upper) / 2 @ self.axes
        return np.stack([middle - reach, middle + reach])


def sweep(
    bones: str,
    start: ArrayLike,
    end: ArrayLike,
    rows: Iterable[tuple[float, ...]],
    *,
    caps: tuple[float, float],
    blend: float,
    front: ArrayLike = (0, 0, 1),
    power: float = 2.0,
    carve: bool = False,
) -> Part:
    """A part along a segment; short rows of the profile are filled with zeros (no shift)."""
    profile = np.array([[*row, *([0.0] * (5 - len(row)))] for row in rows], dtype=np.float64)
    first, last = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    axis = last - first
    return Part(
        bones=tuple(bones.split()), start=first, axes=part_axes(axis, front),
        length=float(np.linalg.norm(axis)), profile=profile, caps=caps, blend=blend, power=power, carve=carve,
    )  # fmt: skip


def ellipsoid(
    bones: str,
    center: ArrayLike,
    radii: tuple[float, float, float],
    *,
    blend: float,
    axis: ArrayLike = (0, 1, 0),
    front: ArrayLike = (0, 0, 1),
    power: float = 2.0,
    carve: bool = False,
) -> Part:
    """An ellipsoid with radii to the side, along `axis` and to the front."""
    middle = np.asarray(center, dtype=np.float64)
    return Part(
        bones=tuple(bones.split()), start=middle, axes=part_axes(axis, front), length=0.0,
        profile=np.array([[0.0, radii[0], radii[2], 0, 0]]), caps=(radii[1], radii[1]),
        blend=blend, power=power, carve=carve,
    )  # fmt: skip


@dataclass(frozen=True)
class Body:
    """Parts joined in order by smooth minima, or carved by smooth maxima: negative inside.

    Attributes
    ----------
    parts : tuple of Part
    """

    parts: tuple[Part, ...]

    def __call__(self, points: Array, far: float = 1.0) -> Array:
        """Field at points (n, 3): near the surface its distance to first order, at most `far`; (n,)."""
        return _field(np.ascontiguousarray(points), far, *self._packed)

    def distances(self, points: Array) -> Array:
        """Approximate signed distance to each part alone, (parts, n)."""
        return _distances(np.ascontiguousarray(points), *self._packed)

    def gradient(self, points: Array, step: float = 5e-4) -> Array:
        """Gradient of the field by central differences, (n, 3)."""
        sides = [(self(points + step * axis), self(points - step * axis)) for axis in np.eye(3)]
        return np.stack([(ahead - behind) / (2 * step) for ahead, behind in sides], axis=1)

    def on_grid(self, axes: tuple[Array, Array, Array], far: float) -> NDArray[np.float32]:
        """Field at the nodes of a rectangular grid, at most `far`; (len(x), len(y), len(z))."""
        value = np.empty(tuple(len(axis) for axis in axes), dtype=np.float32)
        plane = np.stack(np.meshgrid(axes[1], axes[2], indexing="ij"), axis=-1).reshape(-1, 2)
        points = np.concatenate([np.zeros((len(plane), 1)), plane], axis=1)
        for index, x in enumerate(axes[0]):
            points[:, 0] = x
            value[index] = self(points, far).reshape(value.shape[1:])
        return value

    def bounds(self) -> Array:
        """Lower and upper corner of a bounding box, (2, 3)."""
        boxes = np.stack([part.bounds() for part in self.parts if not part.carve])
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])

    @cached_property
    def _packed(self) -> tuple[NDArray, ...]:
        """The parts as arrays, with boxes outside which they cannot touch the surface."""
        outward = np.array([[-1.0], [1.0]])
        boxes = np.stack([part.bounds() + (part.blend + MARGIN) * outward for part in self.parts])
        numbers = np.array(
            [(p.length, *p.caps, p.power, p.blend, p.carve) for p in self.parts], dtype=np.float64
        )
        starts, axes, tables = (
            np.stack([getattr(p, n) for p in self.parts]) for n in ("start", "axes", "table")
        )
        return starts, axes, tables, numbers, boxes


@compiled()
def smooth_min(a: float, b: float, blend: float) -> float:
    """Polynomial smooth minimum, equal to min(a, b) where they differ by more than `blend` (length)."""
    gap = max(blend - abs(a - b), 0.0) / blend
    return min(a, b) - gap * gap * blend / 4


@compiled()
def radial_distance(x: float, y: float, z: float, rx: float, ry: float, rz: float, power: float) -> float:
    """First-order distance (k - 1) / |grad k| to the surface k = 1, with k the p-norm of (x/rx, y/ry, z/rz).

    Exact for a sphere with p = 2.
    """
    u, v, w = abs(x) / rx, abs(y) / ry, abs(z) / rz
    if power == 2.0:  # the same without powers, which cost most of the time
        k = np.sqrt(u * u + v * v + w * w)
        if k < 1e-9:
            return INSIDE
        return (k - 1) * k / np.sqrt((u / rx) ** 2 + (v / ry) ** 2 + (w / rz) ** 2)
    k = (u**power + v**power + w**power) ** (1 / power)
    if k < 1e-9:
        return INSIDE
    e = power - 1
    slope = np.sqrt(((u / k) ** e / rx) ** 2 + ((v / k) ** e / ry) ** 2 + ((w / k) ** e / rz) ** 2)
    return (k - 1) / slope


@compiled()
def _part_distance(p: Array, start: Array, axes: Array, table: Array, numbers: Array) -> float:
    dx, dy, dz = p[0] - start[0], p[1] - start[1], p[2] - start[2]
    side = dx * axes[0, 0] + dy * axes[0, 1] + dz * axes[0, 2]
    along = dx * axes[1, 0] + dy * axes[1, 1] + dz * axes[1, 2]
    forward = dx * axes[2, 0] + dy * axes[2, 1] + dz * axes[2, 2]
    length = numbers[0]
    at = min(max(along, 0.0), length)
    beyond = along - at
    last = table.shape[0] - 1
    position = at / length * last if length > 0 else 0.0
    low = min(int(position), last - 1)
    t = position - low
    width = (1 - t) * table[low, 0] + t * table[low + 1, 0]
    depth = (1 - t) * table[low, 1] + t * table[low + 1, 1]
    shift = (1 - t) * table[low, 2] + t * table[low + 1, 2]
    lift = (1 - t) * table[low, 3] + t * table[low + 1, 3]
    cap = numbers[1] if beyond < 0 else numbers[2]
    return radial_distance(side - shift, beyond, forward - lift, width, cap, depth, numbers[3])


@compiled()
def _distances(
    points: Array, starts: Array, axes: Array, tables: Array, numbers: Array, boxes: Array
) -> Array:
    out = np.empty((len(starts), len(points)))
    for k in range(len(starts)):
        for i in range(len(points)):
            out[k, i] = _part_distance(points[i], starts[k], axes[k], tables[k], numbers[k])
    return out


@compiled()
def _field(
    points: Array, far: float, starts: Array, axes: Array, tables: Array, numbers: Array, boxes: Array
) -> Array:
    out = np.empty(len(points))
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        value = far
        for k in range(len(starts)):
            if x < boxes[k, 0, 0] or x > boxes[k, 1, 0] or y < boxes[k, 0, 1] or y > boxes[k, 1, 1]:
                continue
            if z < boxes[k, 0, 2] or z > boxes[k, 1, 2]:
                continue
            distance = _part_distance(points[i], starts[k], axes[k], tables[k], numbers[k])
            blend = numbers[k, 4]
            if numbers[k, 5] > 0:
                value = -smooth_min(-value, distance, blend)
            else:
                value = smooth_min(value, distance, blend)
        out[i] = value
    return out

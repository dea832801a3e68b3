"""Renderer of oriented point clouds: every point is a disc in its tangent plane, with a z-buffer.

Why not Mitsuba, which the scanner uses? Drawing 5,000 points as spheres takes it about 45 times as long,
most of it to build meshes and their search tree (``pytest tests/benchmarks/test_render_perf.py
--benchmark-only``); a report has some 100 such pictures, and the variant is global to the process. Discs in
the tangent planes also look like a surface where points are dense and show holes as holes: what lies inside
is greyed.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from datasets_gen.compiled import compiled

SUPERSAMPLE = 2
"""Pixels are drawn this many times finer in each direction, then averaged."""

INSIDE = np.array([0.47, 0.45, 0.44])
"""Colour of what is seen through a hole: the inner side of the surface."""

BEHIND = 2 / 3
"""Share of the normals that face away, from which a cloud is seen from behind: half of a closed surface."""

_KEY_LIGHT = np.array([-0.35, 0.55, 0.76])  # right, up, towards the viewer
_AROUND = np.array([(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1), (1, -1), (-1, 1)])


@dataclass(frozen=True)
class Camera:
    """An orthographic view.

    Attributes
    ----------
    rotation : (3, 3) float64
        Rows are the directions right, up and towards the viewer, in the frame of the cloud.
    center : (2,) float64
        What is seen in the middle of the picture, along right and up.
    scale : float
        Pixels per unit of length.
    width, height : int
        Size in pixels.
    """

    rotation: NDArray[np.float64]
    center: NDArray[np.float64]
    scale: float
    width: int
    height: int

    def project(self, points: ArrayLike) -> NDArray[np.float64]:
        """Column, row (downwards), and distance towards the viewer in units of length, (n, 3)."""
        seen = np.asarray(points, float) @ self.rotation.T
        column = self.scale * (seen[:, 0] - self.center[0]) + self.width / 2
        row = self.height / 2 - self.scale * (seen[:, 1] - self.center[1])
        return np.column_stack([column, row, seen[:, 2]])


def look_from(azimuth: float, elevation: float = 12.0, up: int = 1) -> NDArray[np.float64]:
    """Rotation of a camera that stands at an azimuth and elevation.

    Parameters
    ----------
    azimuth, elevation
        Degrees; azimuth 0 looks against the axis that follows `up` cyclically (z for y upwards).
    up
        Axis that points upwards in the picture: 0, 1 or 2.

    Returns
    -------
    (3, 3) float64
        See `Camera.rotation`.
    """
    turn, lift = np.radians(azimuth), np.radians(elevation)
    front, side = np.eye(3)[(up + 1) % 3], np.eye(3)[(up + 2) % 3]
    level = np.cos(turn) * front + np.sin(turn) * side
    towards = np.cos(lift) * level + np.sin(lift) * np.eye(3)[up]
    right = np.cross(np.eye(3)[up], level)
    return np.array([right, np.cross(towards, right), towards])


def best_azimuth(points: ArrayLike, up: int = 1, steps: int = 24) -> float:
    """Azimuth in degrees that shows the most: widest silhouette, then a quarter turn of perspective.

    The view from the widest side hides depth, so it is turned by 25 degrees.
    """
    cloud = np.asarray(points, float)
    azimuths = np.arange(steps) * 180.0 / steps
    widths = [np.ptp(cloud @ look_from(a, 0.0, up)[0]) for a in azimuths]
    return float(azimuths[int(np.argmax(np.round(widths, 6)))]) - 25.0


def seen_from_behind(normals: NDArray[np.float64], towards: NDArray[np.float64]) -> bool:
    """Whether most of a cloud shows its inner side to a viewer, as a scan from the other side does.

    Parameters
    ----------
    normals : (n, 3)
    towards : (3,)
        Direction towards the viewer.
    """
    return bool(len(normals)) and float((normals @ towards < 0).mean()) > BEHIND


def fitted_cameras(
    clouds: list[NDArray[np.float64]],
    rotation: NDArray[np.float64],
    height: int,
    margin: float = 0.04,
) -> list[Camera]:
    """Cameras of one scale, so that clouds can be compared side by side.

    Parameters
    ----------
    clouds
        Each (n, 3); every one gets its own camera, as wide as it needs.
    rotation
        Shared, or one for each cloud (k, 3, 3), see `Camera.rotation`.
    height
        Pixels; fits the tallest cloud.
    margin
        Part of the height left free on each side.
    """
    rotations = np.broadcast_to(rotation, (len(clouds), 3, 3))
    seen = [cloud @ each.T for cloud, each in zip(clouds, rotations, strict=True)]
    low, high = ([f(s[:, :2], axis=0) for s in seen] for f in (np.min, np.max))
    tallest = max(float(h[1] - b[1]) for b, h in zip(low, high, strict=True)) or 1.0
    scale = height * (1 - 2 * margin) / tallest
    pad = 2 * margin * height
    return [
        Camera(each, (b + h) / 2, scale, max(8, int(np.ceil(scale * (h[0] - b[0]) + pad))), height)
        for each, b, h in zip(rotations, low, high, strict=True)
    ]


def disc_radius(points: NDArray[np.float64], neighbours: int = 7) -> float:
    """Radius at which the discs of a surface sampling close up."""
    if len(points) < 2:
        return 1.0
    k = min(neighbours + 1, len(points))
    return 0.72 * float(np.median(cKDTree(points).query(points, k=k)[0][:, -1]))


def render_points(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    colors: NDArray[np.float64],
    camera: Camera,
    radius: float | None = None,
) -> NDArray[np.uint8]:
    """Draw a cloud.

    Parameters
    ----------
    points, normals : (n, 3)
    colors : (n, 3)
        sRGB in [0, 1].
    camera
    radius
        Of the discs, in units of length; by default from the spacing of the points.

    Returns
    -------
    (height, width, 4) uint8
        RGBA on a transparent background.
    """
    fine = SUPERSAMPLE * camera.scale
    shape = (SUPERSAMPLE * camera.height, SUPERSAMPLE * camera.width)
    seen = camera.project(points) * [SUPERSAMPLE, SUPERSAMPLE, fine]
    facing = normals @ camera.rotation.T
    size = fine * (disc_radius(points) if radius is None else radius)
    depth, winner = _splat(seen, facing, max(size, 1.0), *shape)
    hit = winner >= 0
    image = np.zeros((*shape, 4), np.float32)
    if hit.any():
        tint = np.where(facing[:, 2:] > 0, colors, 0.25 * colors + 0.75 * INSIDE) * _shade(facing)[:, None]
        image[hit, :3] = tint[winner[hit]] * _edges(depth, size)[hit][:, None]
        image[hit, 3] = 1.0
    return _average(image)


def _shade(facing: NDArray[np.float64]) -> NDArray[np.float64]:
    """Ambient, head and key light on a diffuse surface; both sides are lit alike, (n,)."""
    outward = facing * np.where(facing[:, 2:] < 0, -1.0, 1.0)
    key = np.maximum(outward @ (_KEY_LIGHT / np.linalg.norm(_KEY_LIGHT)), 0.0)
    return np.minimum(0.52 + 0.22 * outward[:, 2] + 0.30 * key, 1.0)


def _average(image: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Mean over the fine pixels, colours weighted by their coverage."""
    step = range(SUPERSAMPLE)
    total = np.sum([image[i::SUPERSAMPLE, j::SUPERSAMPLE] for i in step for j in step], axis=0)
    covered = total[..., 3:]
    rgba = np.concatenate([total[..., :3] / np.maximum(covered, 1), covered / SUPERSAMPLE**2], axis=2)
    return np.round(255 * rgba).clip(0, 255).astype(np.uint8)


@compiled()
def _splat(
    seen: NDArray[np.float64], facing: NDArray[np.float64], size: float, height: int, width: int
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Depth (-inf where empty) and index (-1) of the nearest disc in every pixel."""
    depth = np.full((height, width), -np.inf)
    winner = np.full((height, width), -1, dtype=np.int64)
    for i in range(len(seen)):
        x, y, z = seen[i]
        nx, ny, nz = facing[i, 0], -facing[i, 1], facing[i, 2]  # rows run downwards
        steep = max(abs(nz), 0.2) if nz >= 0 else -max(abs(nz), 0.2)
        for row in range(max(0, int(y - size)), min(height, int(y + size) + 2)):
            for col in range(max(0, int(x - size)), min(width, int(x + size) + 2)):
                dx, dy = col + 0.5 - x, row + 0.5 - y
                dz = -(nx * dx + ny * dy) / steep
                if dx * dx + dy * dy + dz * dz <= size * size and z + dz > depth[row, col]:
                    depth[row, col] = z + dz
                    winner[row, col] = i
    return depth, winner


@compiled()
def _edges(depth: NDArray[np.float64], size: float) -> NDArray[np.float64]:
    """Darkening where the surface falls behind its surroundings (eye-dome lighting [Boucheny 2009])."""
    height, width = depth.shape
    reach = max(2, round(size / 2))
    shade = np.ones((height, width))
    for row in range(height):
        for col in range(width):
            if depth[row, col] == -np.inf:
                continue
            behind = 0.0
            for k in range(len(_AROUND)):
                i, j = row + reach * _AROUND[k, 0], col + reach * _AROUND[k, 1]
                if 0 <= i < height and 0 <= j < width and depth[i, j] > -np.inf:
                    fall = (depth[i, j] - depth[row, col]) / (4 * size) - 0.25
                    behind += min(max(fall, 0.0), 1.0)
            shade[row, col] = np.exp(-0.9 * behind / len(_AROUND))
    return shade

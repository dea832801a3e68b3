"""The camera: rays through pixel centres, and where the object appears."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scanner_sim.scanner_config import ScannerConfig

Window = tuple[int, int, int, int]
"""Part of the image: first column and row, columns and rows."""

ITERATIONS = 30


def camera_rays(pixels: NDArray[np.integer], config: ScannerConfig) -> NDArray[np.float64]:
    """Directions through pixel centres.

    Parameters
    ----------
    pixels : (n, 2)
        Column and row.
    config

    Returns
    -------
    (n, 3) float64
        In camera coordinates, with depth 1.
    """
    width, height = config.resolution
    x = (pixels[:, 0] + 0.5 - width / 2) / config.focal
    y = (pixels[:, 1] + 0.5 - height / 2) / config.focal
    if any(config.distortion):
        x, y = undistorted(x, y, *config.distortion)
    return np.stack([x, y, np.ones(len(pixels))], axis=1)


def distorted(x: Any, y: Any, k1: Any, k2: Any) -> tuple[Any, Any]:
    """Radial distortion of normalised image coordinates: ``x (1 + k1 r^2 + k2 r^4)``."""
    square = x * x + y * y
    factor = 1 + square * (k1 + square * k2)
    return x * factor, y * factor


def undistorted(x: Any, y: Any, k1: Any, k2: Any) -> tuple[Any, Any]:
    """Inverse of `distorted`, by fixed-point iteration; arrays of NumPy or Dr.Jit, or numbers."""
    u, v = x, y
    for _ in range(ITERATIONS):
        square = u * u + v * v
        factor = 1 + square * (k1 + square * k2)
        u, v = x / factor, y / factor
    return u, v


def visible_window(vertices: NDArray[np.float64], config: ScannerConfig) -> Window | None:
    """Part of the image that can show the object; None if it lies outside.

    Parameters
    ----------
    vertices : (v, 3)
        In camera coordinates.
    config
    """
    size = np.array(config.resolution)
    if (vertices[:, 2] <= 1e-6).any() or any(config.distortion):  # which bends the edges between vertices
        return 0, 0, int(size[0]), int(size[1])
    place = vertices[:, :2] / vertices[:, 2:] * config.focal + size / 2
    low = np.clip(np.floor(place.min(axis=0)).astype(int) - 1, 0, size)
    high = np.clip(np.ceil(place.max(axis=0)).astype(int) + 1, 0, size)
    if (high <= low).any():
        return None
    return int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])

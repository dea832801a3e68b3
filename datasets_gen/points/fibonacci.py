"""Points spread evenly over the sphere by a formula."""

import numpy as np
from numpy.typing import NDArray


def fibonacci_sphere(count: int) -> NDArray[np.float64]:
    """Spherical Fibonacci points about the y axis: unit vectors of nearly equal areas, (count, 3)."""
    index = np.arange(count)
    y = 1 - (2 * index + 1) / count
    angle = np.pi * (3 - np.sqrt(5)) * index
    radius = np.sqrt(1 - y**2)
    return np.stack([radius * np.cos(angle), y, radius * np.sin(angle)], axis=1)

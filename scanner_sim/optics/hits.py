"""What the camera of one view hits: where its rays meet the object, and the light that returns from there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Hits:
    """Camera rays of one view that hit the object.

    Attributes
    ----------
    pixels : (n, 2) int32
        Column and row.
    face_ids : (n,) int32
    barycentrics : (n, 3) float64
    points : (n, 3) float64
        Hits in camera coordinates, mm (x right, y down, z forward).
    normals : (n, 3) float64
        Shading normals there.
    radiance : (n,) float64
        BSDF times cosine times pi towards the camera: for a white diffuse surface the cosine between normal
        and direction to the laser; 0 in shadow.
    """

    pixels: NDArray[np.int32]
    face_ids: NDArray[np.int32]
    barycentrics: NDArray[np.float64]
    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    radiance: NDArray[np.float64]

    @classmethod
    def none(cls) -> "Hits":
        """Of a view that the object does not enter."""
        empty = np.empty((0, 3))
        return cls(np.empty((0, 2), np.int32), np.empty(0, np.int32), empty, empty, empty, np.empty(0))

"""The rig's frame: where the mesh stands before camera and laser, and millimetres per mesh unit."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.shape import Shape


@dataclass(frozen=True)
class RigFrame:
    """Placement of the mesh in the rig: mesh coordinates x are ``scale * (x - center)`` millimetres.

    Attributes
    ----------
    center : (3,) float64
        Centre of the mesh's bounding box, in mesh units.
    scale : float
        Millimetres per mesh unit.
    diagonal : float
        Of the bounding box, mm.
    """

    center: NDArray[np.float64]
    scale: float
    diagonal: float

    @classmethod
    def of(cls, shape: Shape, object_size: float) -> "RigFrame":
        """Place the rig so that the largest side of the shape measures `object_size` mm."""
        low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        scale = object_size / float((high - low).max())
        return cls((low + high) / 2, scale, scale * float(np.linalg.norm(high - low)))

    def to_rig(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mesh coordinates to mm."""
        return (points - self.center) * self.scale

    def to_mesh(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mm to mesh coordinates."""
        return points / self.scale + self.center

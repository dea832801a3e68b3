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
        Centre of the surface's bounding box, in mesh units.
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
        low, high = shape.bounds
        scale = object_size / float((high - low).max())
        return cls((low + high) / 2, scale, scale * float(np.linalg.norm(high - low)))

    def to_rig(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mesh coordinates to mm."""
        return (points - self.center) * self.scale

    def place(self, shape: Shape) -> NDArray[np.float64]:
        """Vertices of a shape in the rig, (v, 3), mm.

        Those that belong to no face with area, wherever they are, are put on one that does: nothing built
        from the vertices, such as the part of the image that can show the object, then depends on them.
        """
        on_surface = shape.on_surface
        vertices = np.where(on_surface[:, None], shape.vertices, shape.vertices[on_surface.argmax()])
        return self.to_rig(vertices)

    def to_mesh(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mm to mesh coordinates."""
        return points / self.scale + self.center

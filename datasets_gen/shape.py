"""The `Shape` type: one mesh in one pose."""

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.meshes.geometry import face_areas, solid_faces
from datasets_gen.record_arrays import check_layout, check_values
from datasets_gen.records import load_record, save_record, unpacking


@dataclass(frozen=True, repr=False)
class Shape:
    """A closed triangle mesh in one pose.

    Attributes
    ----------
    vertices : (v, 3) float64
        Positions in `units`.
    faces : (f, 3) int32
        Vertex ids, counter-clockwise seen from outside.
    name : str
        Unique within a results table: ``"<subject>/<pose>"`` unless given otherwise.
    subject, pose : str
        Shapes of one subject share connectivity: vertex i and face i are the same surface element.
    units : str
        Length unit of `vertices` (``"m"``, ``"mm"`` or ``"unknown"``).
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    name: str
    subject: str
    pose: str
    units: str = "unknown"

    def __repr__(self) -> str:
        """One line: the name, the size and the units."""
        size = f"{len(self.vertices)} vertices, {len(self.faces)} faces"
        return f"Shape({self.name!r}: {size}, units {self.units!r})"

    def at(self, face_ids: NDArray[np.integer], barycentrics: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points at barycentric coordinates.

        Parameters
        ----------
        face_ids : (n,)
        barycentrics : (n, 3)

        Returns
        -------
        (n, 3) float64
        """
        corners = self.vertices[self.faces[face_ids]]  # (n, 3 corners, 3)
        return np.einsum("nc,ncd->nd", barycentrics, corners)

    @property
    def face_areas(self) -> NDArray[np.float64]:
        """Area of each face, (f,)."""
        return face_areas(self.vertices, self.faces)

    @property
    def on_surface(self) -> NDArray[np.bool_]:
        """Which vertices belong to a face with area, (v,); the others are no part of the surface."""
        used = np.zeros(len(self.vertices), dtype=bool)
        used[self.faces[solid_faces(self.vertices, self.faces)]] = True
        return used

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Lowest and highest coordinates of the surface, (2, 3), whatever the vertices off it.

        Zeros if no face has area.
        """
        points = self.vertices[self.on_surface]
        return np.stack([points.min(axis=0), points.max(axis=0)]) if len(points) else np.zeros((2, 3))

    @property
    def diagonal(self) -> float:
        """Length of the diagonal of `bounds`."""
        low, high = self.bounds
        return float(np.linalg.norm(high - low))

    @property
    def area(self) -> float:
        """Total surface area; errors are divided by its square root."""
        return float(self.face_areas.sum())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as ``.npz``."""
        arrays: dict[str, Any] = {"vertices": self.vertices, "faces": self.faces}
        meta = {"name": self.name, "subject": self.subject, "pose": self.pose, "units": self.units}
        save_record(path, "Shape", arrays, meta)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Shape":
        """Read a file written by `save`."""
        arrays, meta = load_record(path, "Shape")
        with unpacking(path, "Shape"):
            check_layout(arrays, {"vertices": "float v 3", "faces": "int f 3"})
            check_values(cls, meta)
            return cls(**arrays, **meta)

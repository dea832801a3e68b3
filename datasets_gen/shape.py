"""The `Shape` and `Collection` types: one mesh, and the poses of one subject."""

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError, load_record, save_record


@dataclass(frozen=True)
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
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)

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
        return cls(**arrays, **meta)


@dataclass(frozen=True)
class Collection:
    """The poses of one subject, with ground truth by construction.

    Attributes
    ----------
    subject : str
    shapes : tuple of Shape
        All with the same faces.
    reference : Shape
        The rest pose; ground truth and geodesics live on it.
    mirror : (v,) int64 or None
        For left-right symmetric subjects, the vertex that mirrors each vertex; None where unknown.
    """

    subject: str
    shapes: tuple[Shape, ...]
    reference: Shape
    mirror: NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        """Check that connectivity is shared."""
        for shape in self.shapes:
            if not np.array_equal(shape.faces, self.reference.faces):
                raise InputError(
                    f"shape {shape.name!r} has other faces than the reference {self.reference.name!r}; "
                    "poses of one subject must share connectivity"
                )

    def __getitem__(self, pose: str) -> Shape:
        """Return the shape of a pose; InputError names the poses there are."""
        for shape in self.shapes:
            if shape.pose == pose:
                return shape
        raise InputError(f"{self.subject!r} has no pose {pose!r}; it has {[s.pose for s in self.shapes]}")

    def canonical(
        self, shape: Shape, face_ids: NDArray[np.integer], barycentrics: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """The same surface points on the reference shape: f(x) of Eq. 18, exactly.

        Parameters
        ----------
        shape
            A shape of this collection, on which the points were scanned.
        face_ids : (n,)
        barycentrics : (n, 3)

        Returns
        -------
        (n, 3) float64
        """
        if shape.subject != self.subject:
            raise InputError(f"shape {shape.name!r} is not of subject {self.subject!r}")
        return self.reference.at(face_ids, barycentrics)

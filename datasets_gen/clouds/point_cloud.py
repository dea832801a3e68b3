"""The `PointCloud` type: what a file of points or of a mesh holds, and what was found on reading it."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PointCloud:
    """Points, and where a file has them normals and faces, in the order of the file.

    Attributes
    ----------
    points : (n, 3) float64
    normals : (n, 3) float64 or None
        As given, of any length; zero or NaN where the file has none for a point.
    remarks : tuple of str
        What was found, dropped or not used; one line each.
    faces : (f, 3) int64 or None
        Triangles of a mesh; None for a cloud.
    """

    points: Array
    normals: Array | None = None
    remarks: tuple[str, ...] = field(default=())
    faces: NDArray[np.int64] | None = None

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    @property
    def is_mesh(self) -> bool:
        """Whether there are faces."""
        return self.faces is not None and len(self.faces) > 0

    def remarked(self, *remarks: str) -> "PointCloud":
        """The same with further remarks; empty ones do not count."""
        return replace(self, remarks=(*self.remarks, *filter(None, remarks)))

    def select(self, kept: NDArray[Any]) -> "PointCloud":
        """The points of a mask or of ids, without faces."""
        normals = None if self.normals is None else self.normals[kept]
        return replace(self, points=self.points[kept], normals=normals, faces=None)


def counted(number: int, thing: str, many: str = "") -> str:
    """A number and a noun: ``1 point``, ``2,000 points``."""
    return f"{number:,} {thing if number == 1 else many or thing + 's'}"

"""The `PointMap` type: for every point of a source, a place on a target."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError

FORMATS = {
    ".npz": (0, "source_to_target and confidence (NumPy)"),
    ".npy": (0, "target indices (NumPy)"),
    ".txt": (None, "a target index per line, then its confidence where there is one"),
    ".csv": (None, "the columns source, target, confidence"),
    ".map": (0, "a target index per line, from 0 (PFARM, CP2P)"),
    ".vts": (1, "a vertex per template point, from 1 (remeshed SCAPE, FAUST and TOSCA)"),
    ".corr": (1, "a target triangle from 1 and three weights per line (SHREC'16 submissions)"),
    ".baryc_gt": (1, "a triangle of the full shape from 1 and three weights per line (SHREC'16 Partial)"),
    ".mat": (1, "source_to_target, from 1 (MATLAB)"),
}
"""Endings, the first index of each (None: the file says it) and what a file holds."""

ON_TRIANGLES = (".corr", ".baryc_gt")
"""Formats whose indices are of triangles, with weights."""


@dataclass(frozen=True)
class PointMap:
    """For every source point a target point, or a point of a target triangle.

    Attributes
    ----------
    ids : (n,) int64
        Target points, or target triangles if there are weights; counted from 0, -1 for none.
    weights : (n, 3) float64 or None
        Barycentric coordinates in the triangles; zero where there is none.
    confidence : (n,) float64 or None
        In [0, 1].

    Raises
    ------
    InputError
        If lengths differ, an index is below -1, or weights are no barycentric coordinates.
    """

    ids: NDArray[np.int64]
    weights: NDArray[np.float64] | None = None
    confidence: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        """Check lengths and ranges."""
        if self.ids.size and self.ids.min() < -1:
            raise InputError(f"index {self.ids.min()} is below -1, which means no match")
        for name in ("weights", "confidence"):
            array = getattr(self, name)
            if array is not None and len(array) != len(self.ids):
                raise InputError(f"{len(self.ids)} indices with {len(array)} rows of {name}")
        if self.weights is not None:
            given = self.weights[self.ids >= 0]
            off = np.abs(given.sum(axis=1) - 1) if len(given) else np.zeros(0)
            bad = ~((off <= TOLERANCE) & (given >= -TOLERANCE).all(axis=1)) if len(given) else off > 0
            if bad.any():
                row = int(np.flatnonzero(self.ids >= 0)[bad.argmax()])
                raise InputError(
                    f"weights {self.weights[row].tolist()} of row {row + 1} are no barycentric coordinates: "
                    "they must be positive and sum to 1"
                )

    def __len__(self) -> int:
        """Return the number of source points."""
        return len(self.ids)

    @property
    def matched(self) -> NDArray[np.bool_]:
        """Which source points have a match, (n,)."""
        return self.ids >= 0

    def check_target(self, points: int, triangles: int, name: str) -> None:
        """Raise InputError if an index is beyond a target of so many points and triangles.

        Parameters
        ----------
        points, triangles
        name
            Of the map, for the message.
        """
        count, what = (points, "points") if self.weights is None else (triangles, "triangles")
        if len(self.ids) and self.ids.max() >= count:
            hint = "; its indices may count from 1" if self.ids.max() == count else ""
            raise InputError(f"{name} names number {self.ids.max()} of a target of {count} {what}{hint}")


TOLERANCE = 1e-3
"""By how much weights may be negative or miss a sum of 1: files hold few digits."""

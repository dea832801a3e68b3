"""The `Collection` type: the poses of one subject, with the file that the cache and the results share."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.record_arrays import check_ids, check_layout, check_values
from datasets_gen.records import InputError, load_record, save_record, unpacking
from datasets_gen.shape import Shape

_KIND = "Collection"


@dataclass(frozen=True, repr=False)
class Collection:
    """The poses of one subject, with ground truth by construction.

    ``len(body)`` is the number of poses, iteration gives their shapes, ``body["walk"]`` is the shape of one
    pose.

    Attributes
    ----------
    subject : str
    shapes : tuple of Shape
        All with the same faces.
    reference : Shape
        The rest pose; ground truth and geodesics live on it.
    mirror : (v,) int64 or None
        For left-right symmetric subjects, the vertex that mirrors each vertex; None where unknown.

    Raises
    ------
    InputError
        If the shapes differ in their faces.
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

    def __len__(self) -> int:
        """Return the number of poses."""
        return len(self.shapes)

    def __iter__(self) -> Iterator[Shape]:
        """Go through the shapes, in order."""
        return iter(self.shapes)

    def __getitem__(self, pose: str) -> Shape:
        """Return the shape of a pose; InputError names the poses there are."""
        for shape in self.shapes:
            if shape.pose == pose:
                return shape
        raise InputError(f"{self.subject!r} has no pose {pose!r}; it has {list(self.poses)}")

    def __repr__(self) -> str:
        """One line: subject, poses, size."""
        size = f"{len(self.reference.vertices):,} vertices, {len(self.reference.faces):,} faces"
        return f"Collection({self.subject!r}: {', '.join(self.poses)}; {size})"

    @property
    def poses(self) -> tuple[str, ...]:
        """Names of the poses, in order."""
        return tuple(shape.pose for shape in self.shapes)

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
            In the units of the reference.

        Raises
        ------
        InputError
            If the shape is of another subject.
        """
        if shape.subject != self.subject:
            raise InputError(f"shape {shape.name!r} is not of subject {self.subject!r}")
        return self.reference.at(face_ids, barycentrics)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all poses and the reference as one ``.npz``.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        stored = {shape.pose: shape for shape in (self.reference, *self.shapes)}
        arrays: dict[str, Any] = {
            "faces": self.reference.faces,
            "vertices": np.stack([shape.vertices for shape in stored.values()]),
        }
        if self.mirror is not None:
            arrays["mirror"] = self.mirror
        meta = {
            "subject": self.subject,
            "reference": self.reference.pose,
            "poses": list(self.poses),
            "stored": list(stored),
            "names": [shape.name for shape in stored.values()],
            "units": self.reference.units,
        }
        save_record(path, _KIND, arrays, meta)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Collection":
        """Read a file written by `save`.

        Raises
        ------
        InputError
            If the file is missing, cut short, or holds something else.
        """
        arrays, meta = load_record(path, _KIND)
        with unpacking(path, _KIND):
            _check(arrays, meta)
            shapes = {
                pose: Shape(vertices, arrays["faces"], name, meta["subject"], pose, meta["units"])
                for pose, name, vertices in zip(
                    meta["stored"], meta["names"], arrays["vertices"], strict=True
                )
            }
            chosen = tuple(shapes[pose] for pose in meta["poses"])
            return cls(meta["subject"], chosen, shapes[meta["reference"]], arrays.get("mirror"))


def _check(arrays: Mapping[str, Any], meta: Mapping[str, Any]) -> None:
    """Raise ValueError unless the arrays and names of a file make poses."""
    mirror = {"mirror": "int v"} if "mirror" in arrays else {}
    layout = {"vertices": "float p v 3", "faces": "int f 3", **mirror}
    vertices = check_layout(arrays, layout, finite="vertices")["v"]
    for name in ("faces", *mirror):
        check_ids(arrays[name], vertices, name)
    check_values(Shape, {"subject": meta["subject"], "units": meta["units"]})
    for pose, name in zip(meta["stored"], meta["names"], strict=True):
        check_values(Shape, {"pose": pose, "name": name})

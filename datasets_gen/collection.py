"""The `Collection` type: the poses of one subject, with the file that the cache and the results share."""

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.mesh_placement import MeshPlacement
from datasets_gen.paths import check_text
from datasets_gen.record_arrays import check_ids, check_layout, check_values
from datasets_gen.records import InputError, load_record, save_record, unpacking
from datasets_gen.shape import Shape

_KIND = "Collection"
_OWN = ("own_vertices", "own_faces", "place_faces", "place_weights")
"""Arrays of a file for a shape with a placement, each followed by the number of the shape."""


@dataclass(frozen=True, repr=False)
class Collection:
    """The poses of one subject, with ground truth by construction.

    ``len(body)`` is the number of poses, iteration gives their shapes, ``body["walk"]`` is the shape of one
    pose.

    Attributes
    ----------
    subject : str
    shapes : tuple of Shape
        All with the faces of the reference, but for those that have a placement.
    reference : Shape
        The rest pose; ground truth and geodesics live on it.
    mirror : (v,) int64 or None
        For left-right symmetric subjects, the vertex that mirrors each vertex; None where unknown.
    placements : mapping of str to MeshPlacement
        By pose, of shapes with a mesh of their own (parts, other meshings): where they lie on the reference.
    remarks : tuple of str
        What loading found out and changed, each one line.
    truth : bool
        Whether places on the shapes are known to correspond. False for frames of a capture: each has a mesh
        of its own and no placement, and the reference is but the first of them.

    Raises
    ------
    InputError
        If there is truth, and a shape without a placement differs in its faces, or a placement does not fit
        its shape.
    """

    subject: str
    shapes: tuple[Shape, ...]
    reference: Shape
    mirror: NDArray[np.int64] | None = None
    placements: Mapping[str, MeshPlacement] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    truth: bool = True

    def __post_init__(self) -> None:
        """Check the names, and that connectivity is shared, or bridged by a placement."""
        check_names(self.subject, self.poses)
        for shape in self.shapes:
            placement = self.placements.get(shape.pose)
            if placement is not None:
                if len(placement.face_ids) != len(shape.vertices):
                    raise InputError(
                        f"shape {shape.name!r} has {len(shape.vertices)} vertices, its ground truth "
                        f"{len(placement.face_ids)} entries; give one for each vertex"
                    )
            elif self.truth and not np.array_equal(shape.faces, self.reference.faces):
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
            If the shape is of another subject, or there is no ground truth.
        """
        return self.reference.at(*self.on_reference(shape, face_ids, barycentrics))

    def on_reference(
        self, shape: Shape, face_ids: NDArray[np.integer], barycentrics: NDArray[np.float64]
    ) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        """The same surface points as faces of the reference and barycentric coordinates.

        The identity where the shape has the faces of the reference; else `MeshPlacement.carried`.

        Parameters
        ----------
        shape
            A shape of this collection, on which the points were scanned.
        face_ids : (n,)
        barycentrics : (n, 3)

        Returns
        -------
        face_ids : (n,) int32
        barycentrics : (n, 3) float64

        Raises
        ------
        InputError
            If the shape is of another subject, or there is no ground truth.
        """
        if not self.truth:
            raise InputError(no_truth(self.subject))
        if shape.subject != self.subject:
            raise InputError(f"shape {shape.name!r} is not of subject {self.subject!r}")
        placement = self.placements.get(shape.pose)
        if placement is None:
            return np.asarray(face_ids, dtype=np.int32), barycentrics
        return placement.carried(shape, self.reference, face_ids, barycentrics)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all poses and the reference as one ``.npz``.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        stored = {shape.pose: shape for shape in (self.reference, *self.shapes)}
        own = [pose for pose in stored if self._has_own_mesh(pose)]
        shared = [shape.vertices for pose, shape in stored.items() if pose not in own]
        arrays: dict[str, Any] = {"faces": self.reference.faces, "vertices": np.stack(shared)}
        for number, pose in enumerate(stored):
            placement = self.placements.get(pose)
            mesh = (stored[pose].vertices, stored[pose].faces) if pose in own else ()
            place = () if placement is None else (placement.face_ids, placement.barycentrics)
            arrays |= {f"{name}_{number}": each for name, each in zip(_OWN, (*mesh, *place), strict=False)}
        if self.mirror is not None:
            arrays["mirror"] = self.mirror
        meta = {
            "subject": self.subject,
            "reference": self.reference.pose,
            "poses": list(self.poses),
            "stored": list(stored),
            "names": [shape.name for shape in stored.values()],
            "units": self.reference.units,
            "remarks": list(self.remarks),
            "truth": self.truth,
        }
        save_record(path, _KIND, arrays, meta)

    def _has_own_mesh(self, pose: str) -> bool:
        """Whether a pose is stored with its faces; the reference has those of all others."""
        return pose in self.placements or (not self.truth and pose != self.reference.pose)

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
            shared, shapes, placements = iter(arrays["vertices"]), {}, {}
            for number, (pose, name) in enumerate(zip(meta["stored"], meta["names"], strict=True)):
                own = [arrays[f"{each}_{number}"] for each in _OWN if f"{each}_{number}" in arrays]
                vertices, faces, *place = own or (next(shared), arrays["faces"])
                shapes[pose] = Shape(vertices, faces, name, meta["subject"], pose, meta["units"])
                if place:
                    placements[pose] = MeshPlacement(*place)
            chosen = tuple(shapes[pose] for pose in meta["poses"])
            rest, mirror = shapes[meta["reference"]], arrays.get("mirror")
            remarks, truth = tuple(meta.get("remarks", ())), meta.get("truth", True)
            return cls(meta["subject"], chosen, rest, mirror, placements, remarks, truth)


def check_names(subject: str, poses: Iterable[str]) -> None:
    """Raise InputError if the name of a subject or a pose holds what no table can (`paths.check_text`)."""
    check_text(subject, "subject")
    for pose in poses:
        check_text(pose, "pose")


def no_truth(subject: str) -> str:
    """Why a subject without ground truth cannot be scored, and what can be done with it."""
    return (
        f"{subject!r} has no ground truth, as its frames have meshes of their own: nothing can be scored; "
        "match two of its files with `medialbench match A B --picture MAP.png`"
    )


def _check(arrays: Mapping[str, Any], meta: Mapping[str, Any]) -> None:
    """Raise ValueError unless the arrays and names of a file make poses."""
    mirror = {"mirror": "int v"} if "mirror" in arrays else {}
    layout = {"vertices": "float p v 3", "faces": "int f 3", **mirror}
    sizes = check_layout(arrays, layout, finite="vertices")
    vertices, shared = sizes["v"], len(meta["stored"])
    for name in ("faces", *mirror):
        check_ids(arrays[name], vertices, name)
    if not all(len(array) for name, array in arrays.items() if name.startswith("faces")):
        raise ValueError("a pose has no faces")
    for number in range(len(meta["stored"])):
        names = [f"{each}_{number}" for each in _OWN]
        if any(name in arrays for name in names):
            shared -= 1
            kinds = ("float w 3", "int g 3", "int w", "float w 3")
            some = len(names) if any(name in arrays for name in names[2:]) else 2
            layout = dict(zip(names[:some], kinds, strict=False))
            own = check_layout(arrays, layout, finite=" ".join(names[:some:3]))["w"]
            check_ids(arrays[names[1]], own, names[1])
            if some > 2:
                check_ids(arrays[names[2]], len(arrays["faces"]), names[2])
    if shared != sizes["p"]:
        raise ValueError(f"vertices of {sizes['p']} poses for {shared}")
    check_values(Shape, {"subject": meta["subject"], "units": meta["units"]})
    if not all(isinstance(remark, str) for remark in meta.get("remarks", ())):
        raise ValueError("remarks are no texts")
    if not isinstance(meta.get("truth", True), bool):
        raise ValueError("truth is neither true nor false")
    for pose, name in zip(meta["stored"], meta["names"], strict=True):
        check_values(Shape, {"pose": pose, "name": name})

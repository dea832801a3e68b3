"""Bones, poses and the transforms that a pose gives to the bones."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from datasets_gen.implicit import unit

Array = NDArray[np.float64]
Angles = tuple[float, float, float]
Pose = Mapping[str, Angles]


@dataclass(frozen=True)
class Bone:
    """A rigid segment that turns about its head.

    Attributes
    ----------
    name : str
        Bones of the left and right side end in ``.L`` and ``.R``.
    parent : str or None
    head, tail : (3,)
        In the rest pose, metres; x to the left of the body, y up, z to the front.
    axes : (3, 3)
        Rows: axes of flexion, twist (from head to tail) and swing, in the rest pose. They are mirrored as
        axial vectors, so equal angles on both sides are mirror images.
    """

    name: str
    parent: str | None
    head: Array
    tail: Array
    axes: Array

    def mirrored(self) -> "Bone":
        """The bone of the other side."""

        def swap(name: str | None) -> str | None:
            return name[:-2] + ".R" if name and name.endswith(".L") else name

        flip, axial = np.array([-1.0, 1, 1]), np.array([1.0, -1, -1])
        return Bone(swap(self.name) or "", swap(self.parent), self.head * flip, self.tail * flip, self.axes * axial)


def bone(name: str, parent: str | None, head: ArrayLike, tail: ArrayLike, hinge: ArrayLike) -> Bone:
    """A bone whose positive flexion turns about `hinge`, made orthogonal to the bone."""
    start, end = np.asarray(head, dtype=np.float64), np.asarray(tail, dtype=np.float64)
    along, axis = unit(end - start), np.asarray(hinge, dtype=np.float64)
    axis = unit(axis - (axis @ along) * along)
    return Bone(name, parent, start, end, np.stack([axis, along, np.cross(axis, along)]))


@dataclass(frozen=True)
class Skeleton:
    """Bones, parents before children.

    Attributes
    ----------
    bones : tuple of Bone
    """

    bones: tuple[Bone, ...]

    def index(self, name: str) -> int:
        """Position of a bone."""
        return [b.name for b in self.bones].index(name)

    def transforms(self, pose: Pose) -> tuple[Array, Array]:
        """Rotation (b, 3, 3) and translation (b, 3) that take each bone from rest into a pose.

        Parameters
        ----------
        pose
            (flexion, twist, swing) in degrees of the bones that turn relative to their parents. The twist
            is applied first, then the swing, then the flexion.
        """
        unknown = set(pose) - {b.name for b in self.bones}
        if unknown:
            raise KeyError(f"no bones {sorted(unknown)}")
        turns, shifts = np.empty((len(self.bones), 3, 3)), np.empty((len(self.bones), 3))
        for i, part in enumerate(self.bones):
            flex, twist, swing = np.radians(pose.get(part.name, (0.0, 0.0, 0.0)))
            local = (
                Rotation.from_rotvec(flex * part.axes[0])
                * Rotation.from_rotvec(swing * part.axes[2])
                * Rotation.from_rotvec(twist * part.axes[1])
            ).as_matrix()
            turn, shift = np.eye(3), np.zeros(3)
            if part.parent is not None:
                turn, shift = turns[self.index(part.parent)], shifts[self.index(part.parent)]
            turns[i] = turn @ local
            shifts[i] = turn @ (part.head - local @ part.head) + shift
        return turns, shifts


def segment_distance(points: Array, start: Array, end: Array) -> Array:
    """Distance of points (n, 3) from a segment, (n,)."""
    along = end - start
    at = np.clip((points - start) @ along / (along @ along), 0, 1)
    return np.linalg.norm(points - start - at[:, None] * along, axis=1)

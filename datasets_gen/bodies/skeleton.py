"""Bones, poses and the transforms that a pose gives to the bones."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from datasets_gen.bodies.implicit_surface import unit

Array = NDArray[np.float64]
Angles = tuple[float, float, float]
Pose = Mapping[str, Angles]
Range = tuple[float, float]
Limits = Mapping[str, tuple[Range, Range, Range]]
"""Least and greatest flexion, twist and swing in degrees by bone, without the side: both sides are alike."""


def other_side(name: str) -> str:
    """Name of the right counterpart of a left bone or region; names without a side are unchanged."""
    return name[:-2] + ".R" if name.endswith(".L") else name


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
        flip, axial = np.array([-1.0, 1, 1]), np.array([1.0, -1, -1])
        parent = other_side(self.parent) if self.parent else None
        return Bone(other_side(self.name), parent, self.head * flip, self.tail * flip, self.axes * axial)


def hinge(name: str, parent: str | None, head: ArrayLike, tail: ArrayLike, axis: ArrayLike) -> Bone:
    """A bone whose positive flexion turns about `axis`, made orthogonal to the bone."""
    start, end = np.asarray(head, dtype=np.float64), np.asarray(tail, dtype=np.float64)
    along, turn = unit(end - start), np.asarray(axis, dtype=np.float64)
    turn = unit(turn - (turn @ along) * along)
    return Bone(name, parent, start, end, np.stack([turn, along, np.cross(turn, along)]))


def ball(name: str, parent: str | None, head: ArrayLike, tail: ArrayLike, flexion: ArrayLike) -> Bone:
    """A bone in a ball joint: flexion about a given axis, swing (abduction) about z, twist about itself."""
    start, end = np.asarray(head, dtype=np.float64), np.asarray(tail, dtype=np.float64)
    axes = np.stack([unit(flexion), unit(end - start), np.array([0.0, 0.0, 1.0])])
    return Bone(name, parent, start, end, axes)


@dataclass(frozen=True)
class Skeleton:
    """Bones, parents before children.

    Attributes
    ----------
    bones : tuple of Bone
    limits : mapping of str to three ranges
        What the joints of an animal of this kind can do, from the rest pose. A bone that is not named does
        not turn; the root, which places the whole body, may turn freely.
    """

    bones: tuple[Bone, ...]
    limits: Limits = field(default_factory=dict)

    def index(self, name: str) -> int:
        """Position of a bone."""
        return [b.name for b in self.bones].index(name)

    def beyond_limits(self, pose: Pose) -> list[str]:
        """What a pose asks of joints beyond `limits`, a line for each angle; empty for a sound pose."""
        found = []
        for name, angles in pose.items():
            bone = self.bones[self.index(name)]
            if bone.parent is None:
                continue
            ranges = self.limits.get(name.removesuffix(".L").removesuffix(".R"), ((0.0, 0.0),) * 3)
            for kind, angle, (low, high) in zip(("flexion", "twist", "swing"), angles, ranges, strict=True):
                if not low <= angle <= high:
                    found.append(f"{kind} of {name} is {angle:g}, allowed are {low:g} to {high:g} degrees")
        return found

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

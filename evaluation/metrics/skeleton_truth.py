"""The known bones of a built-in body in a pose: what its curve skeleton should look like.

Bones are not quite centre lines (those of legs and arms run through the joints, that of a thick trunk nearer
to its back), so a perfect curve skeleton does not have the distance 0.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.bodies.body_plan import BodyPlan
from datasets_gen.bodies.built_in import BODIES
from datasets_gen.bodies.skeleton import segment_distance
from datasets_gen.bodies.skinning import bone_of
from datasets_gen.collection import Collection
from datasets_gen.records import InputError

Float = NDArray[np.float64]

FREE = 1e-6
"""An end of a segment within this distance of another segment, in metres, is no free end."""


@dataclass(frozen=True)
class BoneSegments:
    """Bones of a posed body as one connected tree of straight segments.

    Attributes
    ----------
    starts, ends : (b, 3) float64
        Bones, and what joins each to its parent.
    tips : (t, 3) float64
        Free ends: what sticks out of the body.
    """

    starts: Float
    ends: Float
    tips: Float

    def distances(self, points: Float) -> Float:
        """Distance of points (n, 3) from the nearest segment, (n,)."""
        pairs = zip(self.starts, self.ends, strict=True)
        return np.min([segment_distance(points, start, end) for start, end in pairs], axis=0)

    def sampled(self, step: float) -> Float:
        """Places on the segments, a step apart at most, (s, 3)."""
        found = []
        for start, end in zip(self.starts, self.ends, strict=True):
            count = max(int(np.ceil(np.linalg.norm(end - start) / step)), 1)
            found.append(start + np.linspace(0, 1, count + 1)[:, None] * (end - start))
        return np.concatenate(found)


def known_bones(body: Collection, pose: str) -> BoneSegments:
    """The bones of a built-in body, where the pose puts them.

    Parameters
    ----------
    body
        As `datasets_gen.load` gives it, of seed 0 and one subject.
    pose

    Raises
    ------
    InputError
        If the body has no bones.
    """
    recipe = BODIES.get(body.subject)
    plan = recipe.plan(0) if recipe else None
    if not isinstance(plan, BodyPlan):
        known = [name for name, each in BODIES.items() if isinstance(each.plan(0), BodyPlan)]
        raise InputError(
            f"the bones of {body.subject!r} are not known; known are those of {', '.join(known)}"
        )
    angles = {**plan.poses, **plan.held_out}[pose]
    turns, shifts = plan.skeleton.transforms(angles)
    drop = _drop(plan, turns, shifts, body.reference.vertices, body[pose].vertices)
    starts, ends = [], []
    for k, bone in enumerate(plan.skeleton.bones):
        head, tail = (turns[k] @ each + shifts[k] for each in (bone.head, bone.tail))
        starts.append(head)
        ends.append(tail)
        if bone.parent is not None:
            parent = plan.skeleton.index(bone.parent)
            starts.append(_nearest_on(head, starts[2 * parent], ends[2 * parent]))
        else:
            starts.append(head)
        ends.append(head)
    begin, finish = np.array(starts) - drop, np.array(ends) - drop
    real = np.linalg.norm(finish - begin, axis=1) > FREE
    return BoneSegments(begin[real], finish[real], _free_ends(begin[real], finish[real]))


def _drop(plan: BodyPlan, turns: Float, shifts: Float, rest: Float, posed: Float) -> Float:
    """By how much the pose was moved so that it stands on y = 0: the median over the skin of its bones."""
    owner = bone_of(rest, plan.surface, plan.skeleton)
    carried = np.einsum("nij,nj->ni", turns[owner], rest) + shifts[owner]
    return np.array([0.0, float(np.median(carried[:, 1] - posed[:, 1])), 0.0])


def _nearest_on(point: Float, start: Float, end: Float) -> Float:
    along = end - start
    return np.asarray(start + np.clip((point - start) @ along / (along @ along), 0, 1) * along)


def _free_ends(starts: Float, ends: Float) -> Float:
    """Ends of segments that no other segment touches."""
    found = []
    for side in (starts, ends):
        for k, point in enumerate(side):
            others = (i for i in range(len(starts)) if i != k)
            if all(segment_distance(point[None], starts[i], ends[i])[0] > FREE for i in others):
                found.append(point)
    return np.array(found).reshape(-1, 3)

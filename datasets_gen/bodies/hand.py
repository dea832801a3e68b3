"""The procedural right hand: skeleton and surface.

Metres; fingers up (y), palm to the front (z), thumb to the left of the body (x). It stands on the stump of
its forearm; the joint of the wrist is at y = `WRIST`, the tip of the middle finger about 0.19 m above it.
Lengths of the bones are those of an adult [BM92].

[BM92] B. Buchholz, T. J. Armstrong, S. A. Goldstein, "Anthropometric data for describing the kinematics of
the human hand", Ergonomics 35(3), 1992.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from datasets_gen.bodies.body_plan import BodyPlan, Detail
from datasets_gen.bodies.hand_poses import LIMITS, POSES
from datasets_gen.bodies.implicit_surface import Body, Part, ellipsoid, sweep, unit
from datasets_gen.bodies.proportions import Region, proportioned, random_scales
from datasets_gen.bodies.skeleton import Bone, Skeleton, hinge

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)

EDGE, SPACING, STIFFNESS = 0.0025, 0.0014, 0.011
WRIST = 0.055
CURL = (0.05, 0.15, 0.23)
"""Tangents of the angles by which the bones of a finger at rest lean to the palm."""


class Finger(NamedTuple):
    """One finger but the thumb."""

    name: str
    knuckle: tuple[float, float, float]
    lean: float
    """Of its direction to the side of the thumb: tangent of the angle."""
    lengths: tuple[float, float, float]
    """Of its bones, from the knuckle to the tip."""
    radius: float
    """Half width at its base."""

    @property
    def joints(self) -> Array:
        """Knuckle, middle joint, last joint and tip of the bone, (4, 3)."""
        steps = [length * unit((self.lean, 1, curl)) for length, curl in zip(self.lengths, CURL, strict=True)]
        return np.asarray(self.knuckle) + np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


FINGERS = (
    Finger("index", (0.0275, WRIST + 0.090, -0.002), 0.11, (0.0405, 0.0245, 0.0165), 0.0091),
    Finger("middle", (0.0055, WRIST + 0.0935, -0.004), 0.015, (0.0445, 0.0285, 0.0175), 0.0093),
    Finger("ring", (-0.0155, WRIST + 0.0875, -0.003), -0.09, (0.0410, 0.0270, 0.0175), 0.0088),
    Finger("little", (-0.0345, WRIST + 0.0780, -0.001), -0.22, (0.0325, 0.0190, 0.0155), 0.0077),
)
THUMB = (
    np.array([0.020, WRIST + 0.016, 0.008]),
    np.array([0.0475, WRIST + 0.0470, 0.0240]),
    np.array([0.0655, WRIST + 0.0730, 0.0320]),
    np.array([0.0750, WRIST + 0.0945, 0.0345]),
)
"""Joints of the thumb from its root at the wrist, and its tip."""
THUMB_PAD = np.array([-0.62, 0.10, 0.78])
"""Where the soft side of the thumb looks; it bends to that side."""


def skeleton() -> Skeleton:
    """Bones of the hand."""
    bones: list[Bone] = [
        hinge("forearm", None, (0, 0, 0), (0, WRIST, 0), X),
        hinge("palm", "forearm", (0, WRIST, 0), (0.004, WRIST + 0.09, 0), X),
    ]
    for parent, name, start, end in zip(
        ("palm", "thumb_root", "thumb"), ("thumb_root", "thumb", "thumb_tip"), THUMB, THUMB[1:], strict=False
    ):
        bones.append(hinge(name, parent, start, end, np.cross(end - start, THUMB_PAD)))
    for finger in FINGERS:
        names = (finger.name, f"{finger.name}_middle", f"{finger.name}_tip")
        for parent, name, start, end in zip(
            ("palm", *names), names, finger.joints, finger.joints[1:], strict=False
        ):
            bones.append(hinge(name, parent, start, end, X))
    return Skeleton(tuple(bones), LIMITS)


def surface() -> Body:
    """Surface of the hand."""
    parts = [*_forearm(), *_palm(), *_thumb()]
    for finger in FINGERS:
        parts += _finger(finger)
    return Body(tuple(parts))


def _forearm() -> list[Part]:
    rows = [(0, 0.0335, 0.0255, 0, 0.001), (0.45, 0.0305, 0.0225, 0, 0.0005), (0.8, 0.0280, 0.0195),
        (1, 0.0285, 0.0185)]  # fmt: skip
    return [
        sweep("forearm palm", (0, 0.004, 0), (0, WRIST + 0.004, 0), rows, caps=(0.006, 0.012), blend=0.01,
            power=2.3),
        ellipsoid("forearm", (-0.0200, WRIST - 0.008, -0.0125), (0.0070, 0.0100, 0.0070), blend=0.012),
    ]  # fmt: skip


def _palm() -> list[Part]:
    rows = [(0, 0.0265, 0.0165, 0.001, 0.001), (0.3, 0.0300, 0.0155, 0, 0.001),
        (0.65, 0.0350, 0.0130, -0.001, 0.0005), (1, 0.0370, 0.0110, -0.001, 0)]  # fmt: skip
    parts = [
        sweep("palm", (0, WRIST + 0.002, 0), (0, WRIST + 0.076, -0.001), rows, caps=(0.012, 0.010),
            blend=0.012, power=2.6),
        sweep("palm", (-0.026, WRIST + 0.012, 0.005), (-0.0335, WRIST + 0.070, 0.006),
            [(0, 0.0110, 0.0120), (0.5, 0.0120, 0.0125), (1, 0.0080, 0.0085)], caps=(0.010, 0.010),
            blend=0.012),
    ]  # fmt: skip
    for finger in FINGERS:
        knuckle = np.asarray(finger.knuckle)
        root = np.array([0.45 * knuckle[0], WRIST + 0.015, -0.004])
        r = finger.radius
        parts += [
            sweep("palm", root, np.add(knuckle, (0, 0.004, -0.0005)), [(0, 0.009, 0.009),
                (0.7, 0.0085, 0.0095), (1, 1.05 * r, 1.08 * r)], caps=(0.008, 0.008), blend=0.010),
            ellipsoid("palm", np.add(knuckle, (0, -0.002, -0.0062)), (0.0052, 0.0075, 0.0050), blend=0.010),
            ellipsoid("palm", np.add(knuckle, (0, 0.003, 0.0060)), (0.0088, 0.0095, 0.0055),
                blend=0.010),
        ]  # fmt: skip
    parts.append(
        sweep("palm", (0.004, WRIST + 0.018, 0.0215), (0.000, WRIST + 0.068, 0.0195),
            [(0, 0.004, 0.003), (0.5, 0.011, 0.0050), (1, 0.012, 0.0030)], caps=(0.010, 0.012), blend=0.018,
            carve=True)
    )  # fmt: skip
    return parts


def _thumb() -> list[Part]:
    root, joint, last, tip = THUMB
    ball = root + 0.55 * (joint - root) + [-0.004, -0.004, 0.004]
    pads = (joint + 0.55 * (last - joint), last + 0.55 * (tip - last))
    pad, outward = unit(THUMB_PAD), -unit(THUMB_PAD)
    parts = [
        sweep("thumb_root", root, joint, [(0, 0.0140, 0.0130), (0.5, 0.0145, 0.0140), (1, 0.0110, 0.0112)],
            caps=(0.014, 0.010), blend=0.016, front=THUMB_PAD),
        ellipsoid("thumb_root", ball, (0.0150, 0.0240, 0.0140), blend=0.012, axis=joint - root,
            front=THUMB_PAD),
        sweep("thumb_root palm", (0.020, WRIST + 0.060, 0.002), np.add(joint, (-0.006, -0.002, -0.006)),
            [(0, 0.007, 0.005), (1, 0.006, 0.0050)], caps=(0.008, 0.008), blend=0.016),
        sweep("thumb", joint, last, [(0, 0.0112, 0.0110), (0.5, 0.0098, 0.0095), (1, 0.0104, 0.0098)],
            caps=(0.009, 0.008), blend=0.009, front=THUMB_PAD),
        sweep("thumb_tip", last, tip, [(0, 0.0106, 0.0098), (0.55, 0.0112, 0.0088), (1, 0.0090, 0.0064)],
            caps=(0.008, 0.0085), blend=0.008, front=THUMB_PAD, power=2.2),
        ellipsoid("thumb", pads[0] + 0.0045 * pad, (0.0078, 0.0110, 0.0066), blend=0.008,
            axis=last - joint, front=THUMB_PAD),
        ellipsoid("thumb_tip", pads[1] + 0.0035 * pad, (0.0085, 0.0115, 0.0068), blend=0.006,
            axis=tip - last, front=THUMB_PAD),
    ]  # fmt: skip
    return [*parts, _nail(last, tip, outward, 0.0115, "thumb_tip")]


def _finger(finger: Finger) -> list[Part]:
    knuckle, middle, last, tip = finger.joints
    r, names = finger.radius, (finger.name, f"{finger.name}_middle", f"{finger.name}_tip")
    parts = [
        sweep(names[0], knuckle, middle, [(0, 1.02 * r, 1.08 * r), (0.35, r, 1.02 * r),
            (0.7, 0.95 * r, 0.94 * r), (1, 0.98 * r, 0.96 * r)], caps=(0.008, 0.007), blend=0.0065),
        sweep(names[1], middle, last, [(0, 0.97 * r, 0.95 * r), (0.5, 0.89 * r, 0.86 * r),
            (1, 0.87 * r, 0.81 * r)], caps=(0.007, 0.006), blend=0.006),
        sweep(names[2], last, tip, [(0, 0.87 * r, 0.81 * r), (0.45, 0.85 * r, 0.77 * r),
            (1, 0.70 * r, 0.56 * r)], caps=(0.006, 0.0072), blend=0.006, power=2.2),
    ]  # fmt: skip
    for name, start, end, size in (
        (names[0], knuckle + 0.35 * (middle - knuckle), middle, 0.80),
        (names[1], middle, last, 0.72),
        (names[2], last, tip, 0.66),
    ):
        length = float(np.linalg.norm(end - start))
        parts.append(
            ellipsoid(name, (start + end) / 2 + 0.30 * r * Z, (size * r, 0.42 * length, 0.86 * size * r),
                blend=0.007, axis=end - start)
        )  # fmt: skip
    for name, joint, size in ((names[0], middle, 1.0), (names[1], last, 0.8)):
        parts.append(
            ellipsoid(name, joint - 0.58 * r * size * Z, (0.62 * r, 0.62 * r, 0.40 * r), blend=0.007)
        )
    return [*parts, _nail(last, tip, -Z, r, names[2])]


def _nail(last: Array, tip: Array, outward: Array, radius: float, bone: str) -> Part:
    """A flat plate on the back of the last bone, of half width and height in proportion to `radius`."""
    along = unit(tip - last)
    outward = unit(outward - (outward @ along) * along)
    center = last + 0.88 * (tip - last) + 0.42 * radius * outward
    return ellipsoid(
        bone, center, (0.46 * radius, 0.0062, 0.24 * radius), blend=0.0015, axis=along - 0.14 * outward,
        front=outward, power=2.8,
    )  # fmt: skip


def regions() -> dict[str, Region]:
    """Regions whose proportions vary."""
    wrist = np.array([0.0, WRIST, 0.0])
    found = {
        "palm": Region(None, wrist, Y, ("forearm", "palm")),
        "thumb": Region("palm", THUMB[0], THUMB[3] - THUMB[0], ("thumb_root", "thumb", "thumb_tip")),
    }
    for finger in FINGERS:
        joints = finger.joints
        bones = (finger.name, f"{finger.name}_middle", f"{finger.name}_tip")
        found[finger.name] = Region("palm", joints[0], joints[3] - joints[0], bones)
    return found


def plan(seed: int = 0) -> BodyPlan:
    """Body plan of the hand; seeds other than 0 vary its proportions."""
    details = [Detail("thumb_tip", (THUMB[2] + THUMB[3]) / 2, 0.018, 0.0020)]
    for finger in FINGERS:
        joints = finger.joints
        for bone, start, end in zip(
            (finger.name, f"{finger.name}_middle", f"{finger.name}_tip"), joints, joints[1:], strict=False
        ):
            details.append(Detail(bone, (start + end) / 2, 0.016, 0.00195))
    default = BodyPlan("hand", skeleton(), surface(), tuple(details), EDGE, SPACING, STIFFNESS, POSES, False)
    return proportioned(default, regions(), random_scales(regions(), seed))

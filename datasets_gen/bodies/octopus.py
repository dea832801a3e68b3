"""The procedural octopus: skeleton and surface.

Metres; y up, eyes to the front (z); eight arms, some 0.55 m long, lie spread on the ground. Arms are numbered
around the body and nearly alike; small differences of length and direction are no help in telling which is
which, and there is no mirror image.
"""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.bodies.body_plan import BodyPlan, Detail
from datasets_gen.bodies.implicit_surface import Body, Part, ellipsoid, part_axes, sweep, unit
from datasets_gen.bodies.octopus_poses import ARMS, BONES, LIMITS, POSES, arm_bone
from datasets_gen.bodies.proportions import Region, both_sides, proportioned, random_scales
from datasets_gen.bodies.skeleton import Bone, Skeleton, hinge

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)

EDGE, SPACING, STIFFNESS = 0.0094, 0.0040, 0.036
TURNS = np.radians([24, 66, 113, 158, 203, 246, 294, 337])
"""Directions of the arms about the vertical, from the front to the left."""
LENGTHS = np.array([0.535, 0.560, 0.575, 0.550, 0.545, 0.580, 0.555, 0.540])
BENDS = (0.020, -0.016, 0.024, 0.014, -0.020, 0.018, -0.022, -0.014)
"""How far the arms lie to the side of a straight line, first to one side and then to the other."""
ROOT, ROOT_HEIGHT, TIP_HEIGHT = 0.050, 0.085, 0.010
ARM = [  # position, half width, half height, lift
    (0.00, 0.0400, 0.0430, 0.000), (0.10, 0.0350, 0.0365, -0.008), (0.25, 0.0285, 0.0290, -0.020),
    (0.45, 0.0220, 0.0215, -0.022), (0.65, 0.0160, 0.0155, -0.013), (0.85, 0.0105, 0.0100, -0.004),
    (1.00, 0.0062, 0.0060, 0.000),
]  # fmt: skip
MANTLE = unit([0, 0.80, -0.60])
NECK = np.array([0, 0.155, -0.010])


def _ends(number: int) -> tuple[Array, Array]:
    """Root and tip of an arm (numbers from 1)."""
    turn, length = TURNS[number - 1], LENGTHS[number - 1]
    outward = np.array([np.sin(turn), 0.0, np.cos(turn)])
    return ROOT * outward + ROOT_HEIGHT * Y, (ROOT + length) * outward + TIP_HEIGHT * Y


def _profile(number: int) -> list[tuple[float, ...]]:
    """Cross-sections of an arm."""
    from scipy.interpolate import PchipInterpolator  # imports scipy.optimize: a sixth of a second

    heights = PchipInterpolator(*np.array(ARM)[:, [0, 3]].T)
    sizes = PchipInterpolator(np.array(ARM)[:, 0], np.array(ARM)[:, 1:3])
    bend = BENDS[number - 1]
    at = np.linspace(0, 1, 2 * BONES + 1)
    return [(float(t), *sizes(t), bend * np.sin(2 * np.pi * t**0.8) * t**0.3, float(heights(t))) for t in at]


def arm_joints(number: int) -> Array:
    """Joints of an arm along its middle, from the root to the tip, (BONES + 1, 3)."""
    start, end = _ends(number)
    side, along, up = part_axes(end - start, Y)
    rows = np.array(_profile(number))[::2]
    length = np.linalg.norm(end - start)
    return start + rows[:, [3]] * side + rows[:, [0]] * length * along + rows[:, [4]] * up


def skeleton() -> Skeleton:
    """Bones of the octopus: none in life, but its arms bend as if there were."""
    bones: list[Bone] = [
        hinge("head", None, (0, 0.08, 0), NECK, X),
        hinge("mantle", "head", NECK, NECK + 0.20 * MANTLE, -X),
    ]
    for number in range(1, ARMS + 1):
        joints = arm_joints(number)
        for k in range(BONES):
            parent = "head" if k == 0 else arm_bone(number, k)
            along = joints[k + 1] - joints[k]
            bones.append(
                hinge(arm_bone(number, k + 1), parent, joints[k], joints[k + 1], np.cross(along, -Y))
            )
    return Skeleton(tuple(bones), LIMITS)


def surface() -> Body:
    """Surface of the octopus."""
    parts = [*_trunk(), *both_sides(_eye())]
    for number in range(1, ARMS + 1):
        start, end = _ends(number)
        bones = " ".join(["head", *(arm_bone(number, k) for k in range(1, BONES + 1))])
        parts.append(
            sweep(bones, start, end, _profile(number), caps=(0.02, 0.014), blend=0.040, front=Y, power=2.2)
        )
    parts.append(ellipsoid("head", (0, 0.030, 0), (0.030, 0.022, 0.030), blend=0.03, carve=True))
    parts.append(
        sweep("head", (-0.030, 0.150, 0.030), (-0.052, 0.128, 0.075), [(0, 0.015, 0.015), (1, 0.011, 0.011)],
            caps=(0.01, 0.006), blend=0.012)
    )  # fmt: skip
    return Body(tuple(parts))


def _trunk() -> list[Part]:
    return [
        ellipsoid("head", (0, 0.085, 0), (0.080, 0.046, 0.078), blend=0.02),
        sweep("head", (0, 0.085, 0.0), NECK + 0.03 * MANTLE, [(0, 0.074, 0.072), (0.5, 0.067, 0.065),
            (1, 0.064, 0.060)], caps=(0.05, 0.05), blend=0.04),
        ellipsoid("head mantle", NECK + 0.135 * MANTLE, (0.104, 0.140, 0.090), blend=0.04, axis=MANTLE,
            front=(0, 0.6, 0.8)),
        ellipsoid("mantle", NECK + 0.185 * MANTLE + [0, -0.01, -0.008], (0.088, 0.100, 0.080), blend=0.04,
            axis=MANTLE, front=(0, 0.6, 0.8)),
    ]  # fmt: skip


def _eye() -> list[Part]:
    place = np.array([0.052, 0.178, 0.030])
    return [
        ellipsoid("head", place, (0.026, 0.028, 0.030), blend=0.022),
        ellipsoid("head", np.add(place, (0.017, 0.008, 0.010)), (0.013, 0.008, 0.014), blend=0.004,
            axis=(-0.3, 1, 0.1)),
        ellipsoid("head", np.add(place, (0.030, 0.010, 0.014)), (0.0075, 0.0028, 0.011), blend=0.004,
            axis=(-0.3, 1, 0.1), carve=True),
    ]  # fmt: skip


def regions() -> dict[str, Region]:
    """Regions whose proportions vary."""
    found = {
        "head": Region(None, np.array([0.0, 0.0, 0.0]), Y, ("head",)),
        "mantle": Region("head", NECK, MANTLE, ("mantle",)),
    }
    for number in range(1, ARMS + 1):
        start, end = _ends(number)
        names = tuple(arm_bone(number, k) for k in range(1, BONES + 1))
        found[f"arm{number}"] = Region("head", start, end - start, names)
    return found


def plan(seed: int = 0) -> BodyPlan:
    """Body plan of the octopus; seeds other than 0 vary its proportions."""
    details = [Detail("head", np.array([0, 0.18, 0.03]), 0.07, 0.0075)]
    for number in range(1, ARMS + 1):
        joints = arm_joints(number)
        details.append(Detail(arm_bone(number, BONES), joints[-1], 0.05, 0.0050))
        details.append(Detail(arm_bone(number, BONES - 2), joints[-3], 0.05, 0.0062))
    default = BodyPlan(
        "octopus", skeleton(), surface(), tuple(details), EDGE, SPACING, STIFFNESS, POSES, False
    )
    return proportioned(default, regions(), random_scales(regions(), seed))

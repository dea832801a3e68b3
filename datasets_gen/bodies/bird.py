"""The procedural bird, a long-necked runner such as a rhea or an emu: skeleton and surface.

Metres; x to the left of the body, y up, z to the front; feet at y = 0, about 1.95 m tall. What looks like a
knee that bends backwards is its ankle; the knee is hidden in the plumage.
"""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.bodies.bird_poses import LIMITS, POSES
from datasets_gen.bodies.body_plan import BodyPlan, Detail
from datasets_gen.bodies.implicit_surface import Body, Part, ellipsoid, sweep, unit
from datasets_gen.bodies.proportions import (
    FLIP,
    Region,
    both_sides,
    proportioned,
    random_scales,
    side_regions,
)
from datasets_gen.bodies.skeleton import Skeleton, hinge

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)

EDGE, SPACING, STIFFNESS = 0.0180, 0.0075, 0.070

NECK = (
    np.array([0, 1.13, 0.36]),
    np.array([0, 1.235, 0.530]),
    np.array([0, 1.395, 0.600]),
    np.array([0, 1.565, 0.590]),
    np.array([0, 1.730, 0.555]),
    np.array([0, 1.870, 0.560]),
)
"""Joints of the neck from the chest to the head."""
BEAK = np.array([0, 1.862, 0.795])
FACE = unit(BEAK - NECK[-1] - [0, 0.022, 0])
BROW = unit(np.cross(FACE, X))
HIP = np.array([0.115, 1.06, -0.03])
KNEE = np.array([0.165, 0.86, 0.135])
ANKLE = np.array([0.145, 0.475, -0.085])
TOES = np.array([0.140, 0.045, 0.015])
TOE_OUT = unit([0.10, 0, 1])
SHOULDER = np.array([0.195, 1.195, 0.150])
ELBOW = np.array([0.322, 1.115, -0.045])
WING_TIP = np.array([0.372, 0.985, -0.300])


def skeleton() -> Skeleton:
    """Bones of the bird."""
    middle = [
        hinge("trunk", None, (0, 1.13, -0.30), (0, 1.13, 0.28), X),
        hinge("tail", "trunk", (0, 1.20, -0.42), (0, 1.27, -0.76), -X),
    ]
    names = ("trunk", "neck_1", "neck_2", "neck_3", "neck_4", "neck_5")
    for parent, name, start, end in zip(names, names[1:], NECK, NECK[1:], strict=False):
        middle.append(hinge(name, parent, start, end, X))
    middle.append(hinge("head", "neck_5", NECK[-1], BEAK, X))
    left = [
        hinge("thigh.L", "trunk", HIP, KNEE, -X),
        hinge("shin.L", "thigh.L", KNEE, ANKLE, X),
        hinge("foot.L", "shin.L", ANKLE, TOES, -X),
        hinge("toes.L", "foot.L", TOES, TOES + 0.16 * TOE_OUT, X),
        hinge("wing.L", "trunk", SHOULDER, ELBOW, Z),
        hinge("wing_tip.L", "wing.L", ELBOW, WING_TIP, Y),
    ]
    return Skeleton((*middle, *left, *(b.mirrored() for b in left)), LIMITS)


def surface() -> Body:
    """Surface of the bird."""
    return Body((*_trunk(), *_neck(), *_head(), *both_sides((*_leg(), *_wing(), *_face_side()))))


def _trunk() -> list[Part]:
    return [
        ellipsoid("trunk", (0, 1.125, -0.060), (0.258, 0.470, 0.268), blend=0.05, axis=Z, front=Y),
        ellipsoid("trunk", (0, 1.085, 0.170), (0.190, 0.280, 0.200), blend=0.07, axis=(0, 0.18, 1), front=Y),
        ellipsoid("trunk", (0, 1.190, -0.280), (0.185, 0.310, 0.165), blend=0.07, axis=(0, 0.05, 1), front=Y),
        sweep("trunk tail", (0, 1.190, -0.44), (0, 1.265, -0.76),
            [(0, 0.130, 0.095), (0.35, 0.108, 0.068), (0.75, 0.080, 0.040, 0, -0.012),
             (1, 0.040, 0.016, 0, -0.030)], caps=(0.08, 0.035), blend=0.08, front=Y),
    ]  # fmt: skip


def _neck() -> list[Part]:
    first, top = NECK[1], NECK[-1]
    axis = unit(top - first)
    forward = unit(Z - (Z @ axis) * axis)
    rows = []
    for joint, radius in zip(NECK[1:], (0.0700, 0.0520, 0.0440, 0.0400, 0.0390), strict=True):
        at = (joint - first) @ axis / np.linalg.norm(top - first)
        rows.append((at, 0.92 * radius, radius, 0.0, (joint - first) @ forward))
    base = [(0, 0.105, 0.120), (0.5, 0.082, 0.092), (1, 0.064, 0.073)]
    return [
        sweep("trunk neck_1", NECK[0], first, base, caps=(0.10, 0.065), blend=0.09),
        sweep(" ".join(f"neck_{k}" for k in range(1, 6)), first, top, rows, caps=(0.06, 0.04), blend=0.05),
    ]


def _head() -> list[Part]:
    crown = NECK[-1] + [0, 0.022, 0]
    return [
        sweep("head", crown - 0.020 * FACE, crown + 0.075 * FACE,
            [(0, 0.050, 0.052), (0.45, 0.051, 0.053), (1, 0.034, 0.034, 0, -0.006)], caps=(0.045, 0.025),
            blend=0.03, front=BROW),
        sweep("head", crown + 0.075 * FACE - 0.006 * BROW, BEAK,
            [(0, 0.034, 0.030), (0.35, 0.028, 0.021), (0.75, 0.022, 0.014), (1, 0.014, 0.010, 0, -0.003)],
            caps=(0.02, 0.014), blend=0.015, front=BROW, power=2.2),
        ellipsoid("head", crown + 0.020 * FACE + 0.034 * BROW, (0.034, 0.048, 0.022), blend=0.03, axis=FACE,
            front=BROW),
    ]  # fmt: skip


def _face_side() -> list[Part]:
    crown = NECK[-1] + [0, 0.022, 0]
    eye = crown + 0.042 * FACE + 0.012 * BROW + 0.043 * X
    return [
        ellipsoid("head", eye + 0.010 * X, (0.010, 0.024, 0.020), blend=0.012, axis=FACE, front=BROW,
            carve=True),
        ellipsoid("head", eye - 0.002 * X, (0.012, 0.0155, 0.0140), blend=0.004, axis=FACE, front=BROW),
    ]  # fmt: skip


def _leg() -> list[Part]:
    thigh = [(0, 0.105, 0.150), (0.4, 0.110, 0.140), (1, 0.082, 0.100)]
    shin = [(0, 0.084, 0.104), (0.3, 0.074, 0.090, 0, -0.010), (0.6, 0.049, 0.058, 0, -0.008),
        (0.85, 0.035, 0.039), (1, 0.037, 0.042)]  # fmt: skip
    foot = [(0, 0.036, 0.041), (0.12, 0.029, 0.033), (0.5, 0.0245, 0.027), (0.85, 0.0260, 0.028),
        (1, 0.031, 0.030)]  # fmt: skip
    parts = [
        sweep("trunk thigh.L", HIP, KNEE - 0.01 * Z, thigh, caps=(0.09, 0.085), blend=0.07),
        sweep("shin.L", KNEE, ANKLE, shin, caps=(0.085, 0.032), blend=0.06),
        sweep("foot.L", ANKLE, TOES, foot, caps=(0.030, 0.028), blend=0.018),
        ellipsoid("foot.L", np.add(ANKLE, (0, 0.004, -0.016)), (0.022, 0.036, 0.024), blend=0.02),
    ]
    side = np.cross(Y, TOE_OUT)
    for turn, length, radius in ((0.0, 0.175, 0.0235), (0.56, 0.125, 0.0205), (-0.56, 0.120, 0.0205)):
        along = unit(np.cos(turn) * TOE_OUT + np.sin(turn) * side)
        base = TOES * [1, 0, 1] + radius * Y + 0.004 * along
        rows = [(0, 1.1 * radius, 1.15 * radius), (0.4, radius, radius), (0.8, 0.9 * radius, 0.8 * radius,
            0, -0.15 * radius), (1, 0.62 * radius, 0.55 * radius, 0, -0.35 * radius)]  # fmt: skip
        parts.append(
            sweep("toes.L", base, base + length * along, rows, caps=(0.02, 0.022), blend=0.012, front=Y)
        )
    return parts


def _wing() -> list[Part]:
    flat = unit([1, 0.35, 0.40])
    upper = [(0, 0.070, 0.055), (0.5, 0.080, 0.042), (1, 0.090, 0.033)]
    lower = [(0, 0.088, 0.033), (0.35, 0.088, 0.029), (0.7, 0.068, 0.024), (1, 0.034, 0.018)]
    return [
        sweep("trunk wing.L", SHOULDER, ELBOW, upper, caps=(0.05, 0.06), blend=0.05, front=flat),
        sweep("wing_tip.L", ELBOW, WING_TIP, lower, caps=(0.06, 0.045), blend=0.03, front=flat),
    ]


def regions() -> dict[str, Region]:
    """Regions whose proportions vary."""
    neck = tuple(f"neck_{k}" for k in range(1, 6))
    middle = {
        "trunk": Region(None, HIP * [0, 1, 1], Z, ("trunk", "tail")),
        "neck": Region("trunk", NECK[0], NECK[-1] - NECK[0], neck),
        "head": Region("neck", NECK[-1], FACE, ("head",)),
    }
    left = {
        "leg.L": Region("trunk", HIP, Y, ("thigh.L", "shin.L", "foot.L", "toes.L")),
        "wing.L": Region("trunk", SHOULDER, WING_TIP - SHOULDER, ("wing.L", "wing_tip.L")),
    }
    return middle | side_regions(left)


def plan(seed: int = 0) -> BodyPlan:
    """Body plan of the bird; seeds other than 0 vary its proportions."""
    details = [
        Detail("head", NECK[-1] + 0.06 * FACE, 0.09, 0.0090),
        Detail("neck_5", NECK[-2], 0.10, 0.0125),
        Detail("neck_3", NECK[2], 0.12, 0.0135),
    ]
    for side, flip in (("L", np.ones(3)), ("R", FLIP)):
        details.append(Detail(f"toes.{side}", (TOES + 0.07 * TOE_OUT) * flip, 0.10, 0.0100))
        details.append(Detail(f"foot.{side}", (ANKLE + TOES) / 2 * flip, 0.10, 0.0120))
        details.append(Detail(f"wing_tip.{side}", WING_TIP * flip, 0.06, 0.0120))
    default = BodyPlan("bird", skeleton(), surface(), tuple(details), EDGE, SPACING, STIFFNESS, POSES, True)
    return proportioned(default, regions(), random_scales(regions(), seed))

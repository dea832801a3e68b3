"""The procedural human: skeleton, surface and poses.

Metres; x to the left of the body, y up, z to the front; soles at y = 0, about 1.75 m tall.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from datasets_gen.bodies.body_plan import BodyPlan, Detail
from datasets_gen.bodies.human_poses import HELD_OUT, LIMITS, POSES
from datasets_gen.bodies.implicit_surface import Body, Part, ellipsoid, sweep, unit
from datasets_gen.bodies.proportions import (
    FLIP,
    Region,
    both_sides,
    proportioned,
    random_scales,
    side_regions,
)
from datasets_gen.bodies.skeleton import Skeleton, ball, hinge

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)

EDGE, SPACING, STIFFNESS = 0.0125, 0.005, 0.065
SIDES_DIFFER = {"arm.R": (0.88, 1.15), "hand.R": (1.05, 1.08), "leg.L": (1.0, 1.10), "foot.L": (1.06, 1.05)}

ARM_DROP = np.radians(46)  # of the rest pose below the horizontal
ARM = np.array([np.cos(ARM_DROP), -np.sin(ARM_DROP), 0.0])
PALM = np.array([-np.sin(ARM_DROP), -np.cos(ARM_DROP), 0.0])
SHOULDER = np.array([0.178, 1.408, -0.022])
ELBOW = SHOULDER + 0.285 * ARM + np.array([0, 0, -0.008])
WRIST = SHOULDER + 0.535 * ARM + np.array([0, 0, 0.012])
HIP = np.array([0.096, 0.905, 0.0])
KNEE = np.array([0.112, 0.49, 0.004])
ANKLE = np.array([0.126, 0.085, -0.028])
TOE_OUT = unit([0.13, 0, 1])
BALL = ANKLE * [1, 0, 1] + 0.135 * TOE_OUT + [0, 0.02, 0]


def skeleton() -> Skeleton:
    """Bones of the human."""
    middle = [
        ball("pelvis", None, (0, 0.95, -0.01), (0, 1.03, -0.005), X),
        ball("waist", "pelvis", (0, 1.04, -0.005), (0, 1.13, -0.005), X),
        ball("ribs", "waist", (0, 1.13, -0.005), (0, 1.24, -0.01), X),
        ball("chest", "ribs", (0, 1.24, -0.01), (0, 1.42, -0.025), X),
        ball("neck", "chest", (0, 1.445, -0.035), (0, 1.55, -0.012), X),
        ball("head", "neck", (0, 1.565, -0.012), (0, 1.72, 0), X),
    ]
    left = [
        hinge("clavicle.L", "chest", (0.025, 1.415, 0.0), SHOULDER, Z),
        ball("upper_arm.L", "clavicle.L", SHOULDER, ELBOW, -X),
        hinge("forearm.L", "upper_arm.L", ELBOW, WRIST, np.cross(ARM, Z)),
        hinge("hand.L", "forearm.L", WRIST, WRIST + 0.17 * ARM, np.cross(ARM, PALM)),
        ball("thigh.L", "pelvis", HIP, KNEE, -X),
        hinge("shin.L", "thigh.L", KNEE, ANKLE, X),
        hinge("foot.L", "shin.L", ANKLE, BALL, -X),
        hinge("toes.L", "foot.L", BALL, BALL + 0.06 * TOE_OUT, -X),
    ]
    return Skeleton((*middle, *left, *(b.mirrored() for b in left)), LIMITS)


def surface() -> Body:
    """Surface of the human."""
    left = [*_chest_side(), *_arm(), *_hand(), *_leg(), *_foot(), *_face_side()]
    return Body((*_torso(), *_head(), *both_sides(left)))


def _torso() -> list[Part]:
    bottom, top = 0.86, 1.465
    outline = [  # height, half width, back, front
        (0.86, 0.142, -0.095, 0.076), (0.90, 0.161, -0.108, 0.086), (0.96, 0.160, -0.105, 0.095),
        (1.02, 0.151, -0.088, 0.101), (1.08, 0.139, -0.070, 0.100), (1.14, 0.138, -0.072, 0.100),
        (1.22, 0.149, -0.090, 0.108), (1.29, 0.160, -0.108, 0.112), (1.36, 0.152, -0.118, 0.094),
        (1.41, 0.122, -0.112, 0.066), (1.44, 0.090, -0.105, 0.043), (1.465, 0.062, -0.092, 0.028),
    ]  # fmt: skip
    rows = [((y - bottom) / (top - bottom), w, (f - b) / 2, 0, (f + b) / 2) for y, w, b, f in outline]
    spine = "pelvis waist ribs chest"
    return [
        sweep(spine, (0, bottom, 0), (0, top, 0), rows, caps=(0.05, 0.02), blend=0.03, power=2.3),
        sweep("neck", (0, 1.42, -0.042), (0, 1.60, -0.004),
            [(0, 0.060, 0.062), (0.5, 0.050, 0.054), (1, 0.051, 0.056)], caps=(0.03, 0.03), blend=0.035),
        ellipsoid(spine, (0, 1.16, 0.118), (0.005, 0.10, 0.010), blend=0.035, carve=True),
        ellipsoid("waist", (0, 1.05, 0.108), (0.007, 0.009, 0.012), blend=0.012, carve=True),
        sweep(spine, (0, 1.04, -0.086), (0, 1.37, -0.130), [(0, 0.008, 0.008), (1, 0.008, 0.008)],
            caps=(0.03, 0.03), blend=0.045, carve=True),
    ]  # fmt: skip


def _head() -> list[Part]:
    return [
        ellipsoid("head", (0, 1.652, -0.012), (0.075, 0.097, 0.094), blend=0.03),
        ellipsoid("head", (0, 1.688, 0.034), (0.057, 0.046, 0.052), blend=0.03),
        sweep("head", (0, 1.675, 0.026), (0, 1.543, 0.044),
            [(0, 0.064, 0.062), (0.45, 0.063, 0.058), (0.75, 0.055, 0.054, 0, 0.002),
             (1, 0.036, 0.040, 0, 0.008)], caps=(0.03, 0.018), blend=0.025),
        ellipsoid("head", (0, 1.545, 0.080), (0.021, 0.016, 0.015), blend=0.025),
        ellipsoid("head", (0, 1.664, 0.079), (0.050, 0.010, 0.012), blend=0.02),
        sweep("head", (0, 1.655, 0.088), (0, 1.610, 0.112),
            [(0, 0.009, 0.012), (0.6, 0.011, 0.013), (1, 0.013, 0.012)], caps=(0.012, 0.010), blend=0.012),
        ellipsoid("head", (0, 1.577, 0.092), (0.025, 0.011, 0.013), blend=0.014),
        ellipsoid("head", (0, 1.577, 0.111), (0.024, 0.0022, 0.008), blend=0.008, carve=True),
    ]  # fmt: skip


def _face_side() -> list[Part]:
    return [
        ellipsoid("head", (0.031, 1.643, 0.100), (0.018, 0.011, 0.016), blend=0.016, carve=True),
        ellipsoid("head", (0.031, 1.642, 0.080), (0.013, 0.0115, 0.013), blend=0.004),
        ellipsoid("head", (0.012, 1.609, 0.103), (0.008, 0.008, 0.010), blend=0.010),
        ellipsoid("head", (0.048, 1.618, 0.068), (0.018, 0.020, 0.020), blend=0.03),
        ellipsoid("head", (0.079, 1.632, -0.008), (0.009, 0.032, 0.019), blend=0.010, axis=(0.15, 1, -0.12),
            front=(0.4, 0, 1)),
        ellipsoid("head", (0.090, 1.636, 0.000), (0.006, 0.018, 0.010), blend=0.006, axis=(0.15, 1, -0.12),
            carve=True),
    ]  # fmt: skip


def _chest_side() -> list[Part]:
    return [
        sweep("chest", (0.030, 1.485, -0.050), np.add(SHOULDER, (-0.025, 0.010, -0.005)),
            [(0, 0.026, 0.030), (1, 0.036, 0.036)], caps=(0.02, 0.03), blend=0.04),
        sweep("chest", (0.02, 1.432, 0.030), np.add(SHOULDER, (-0.01, 0.025, 0.018)),
            [(0, 0.010, 0.010), (1, 0.010, 0.010)], caps=(0.01, 0.01), blend=0.03),
        ellipsoid("chest", (0.076, 1.312, 0.078), (0.075, 0.050, 0.029), blend=0.03, axis=(0.25, 1, -0.1)),
        ellipsoid("chest", (0.115, 1.26, -0.045), (0.048, 0.11, 0.058), blend=0.05),
        ellipsoid("chest", (0.085, 1.345, -0.098), (0.048, 0.062, 0.026), blend=0.035),
        ellipsoid("pelvis", (0.074, 0.905, -0.072), (0.070, 0.076, 0.062), blend=0.035),
    ]  # fmt: skip


def _arm() -> list[Part]:
    rows = [  # position, half thickness, half width to the front, shift to the palm side, shift to the front
        (0.00, 0.050, 0.056, 0.000, 0.000), (0.14, 0.049, 0.054, -0.002, 0.001),
        (0.30, 0.043, 0.048, 0.002, 0.000), (0.42, 0.040, 0.046, 0.002, -0.004),
        (0.53, 0.034, 0.040, 0.000, -0.008), (0.63, 0.039, 0.043, -0.002, -0.003),
        (0.80, 0.031, 0.034, 0.000, 0.004), (0.94, 0.021, 0.028, 0.000, 0.010),
        (1.00, 0.020, 0.028, 0.000, 0.012),
    ]  # fmt: skip
    end = SHOULDER + 0.535 * ARM
    return [
        sweep("upper_arm.L forearm.L", SHOULDER, end, rows, caps=(0.045, 0.02), blend=0.035),
        ellipsoid(
            "upper_arm.L", SHOULDER + 0.05 * ARM - 0.012 * PALM, (0.042, 0.065, 0.050), blend=0.03, axis=ARM
        ),
    ]


def _hand() -> list[Part]:
    parts = [
        sweep("hand.L", WRIST, WRIST + 0.088 * ARM,
            [(0, 0.019, 0.026), (0.35, 0.018, 0.034), (0.8, 0.015, 0.041), (1, 0.012, 0.041)],
            caps=(0.02, 0.010), blend=0.015, power=2.4),
        sweep("hand.L", WRIST + 0.018 * ARM + 0.020 * Z + 0.006 * PALM,
            WRIST + 0.098 * ARM + 0.070 * Z + 0.012 * PALM,
            [(0, 0.016, 0.016), (0.55, 0.0105, 0.0115), (1, 0.0085, 0.0095)], caps=(0.015, 0.009),
            blend=0.018),
    ]  # fmt: skip
    fingers = ((0.0325, 0.070, 0.13, 0.0088), (0.0110, 0.078, 0.03, 0.0090),
        (-0.0110, 0.072, -0.06, 0.0086), (-0.0315, 0.056, -0.16, 0.0076))  # fmt: skip
    for across, length, fan, radius in fingers:
        knuckle = WRIST + 0.082 * ARM + across * Z
        tip = knuckle + (length + 0.008) * unit(ARM + fan * Z + 0.10 * PALM)
        rows = [
            (0, radius, radius),
            (0.5, 0.95 * radius, 0.95 * radius, -0.002),
            (1, 0.8 * radius, 0.85 * radius),
        ]
        parts.append(sweep("hand.L", knuckle, tip, rows, caps=(0.008, 0.008), blend=0.008))
    return parts


def _leg() -> list[Part]:
    rows = [  # height, half width, half depth, shift to the side, shift to the front
        (0.86, 0.074, 0.088, -0.006, 0.000), (0.76, 0.077, 0.087, 0.000, 0.005),
        (0.64, 0.066, 0.076, 0.003, 0.008), (0.54, 0.054, 0.061, 0.0, 0.004),
        (0.49, 0.051, 0.058, 0.0, 0.004), (0.44, 0.049, 0.056, 0.0, -0.003),
        (0.36, 0.053, 0.060, 0.0, -0.013), (0.27, 0.044, 0.049, 0.0, -0.010),
        (0.18, 0.034, 0.037, 0.0, -0.006), (0.10, 0.030, 0.037, 0.0, -0.002), (0.06, 0.030, 0.040, 0.0, 0.0),
    ]  # fmt: skip
    top, bottom = HIP + (ANKLE - HIP) * 0.055, ANKLE + (ANKLE - HIP) * 0.03
    span = top[1] - bottom[1]
    profile = [((top[1] - y) / span, w, d, side, z) for y, w, d, side, z in rows]
    return [
        sweep("thigh.L shin.L", top, bottom, profile, caps=(0.06, 0.02), blend=0.03),
        ellipsoid("shin.L", np.add(KNEE, (0, 0.010, 0.047)), (0.022, 0.028, 0.011), blend=0.02),
        ellipsoid("shin.L", (0.100, 0.37, -0.055), (0.026, 0.075, 0.026), blend=0.03),
        ellipsoid("shin.L", (0.138, 0.38, -0.052), (0.022, 0.065, 0.024), blend=0.03),
        ellipsoid("thigh.L", (0.098, 0.585, 0.045), (0.026, 0.055, 0.026), blend=0.03),
        ellipsoid("shin.L", np.add(ANKLE, (0.030, -0.002, 0.0)), (0.010, 0.013, 0.013), blend=0.012),
        ellipsoid("shin.L", np.add(ANKLE, (-0.030, 0.006, 0.004)), (0.010, 0.013, 0.013), blend=0.012),
    ]


def _foot() -> list[Part]:
    heel = ANKLE * [1, 0, 1] - 0.030 * TOE_OUT
    rows = [  # position, half width, half height, shift to the side, height of the middle
        (0.00, 0.029, 0.030, 0.0, 0.030), (0.22, 0.031, 0.036, 0.0, 0.036), (0.45, 0.034, 0.033, 0.0, 0.033),
        (0.75, 0.043, 0.021, 0.0, 0.021), (1.00, 0.044, 0.013, 0.0, 0.013),
    ]  # fmt: skip
    parts = [
        sweep(
            "foot.L", heel, heel + 0.185 * TOE_OUT, rows, caps=(0.026, 0.012), blend=0.02, front=Y, power=2.5
        )
    ]
    side = np.cross(Y, TOE_OUT)
    toes = ((-0.030, 0.0140, 0.042), (-0.009, 0.0105, 0.036), (0.008, 0.0100, 0.030),
        (0.023, 0.0095, 0.023), (0.036, 0.0090, 0.014))  # fmt: skip
    for across, radius, length in toes:
        base = heel + 0.180 * TOE_OUT + across * side + radius * Y
        taper = [(0, radius, radius), (1, 0.9 * radius, 0.85 * radius)]
        tip = base + length * TOE_OUT
        parts.append(sweep("toes.L", base, tip, taper, caps=(0.012, radius), blend=0.010, front=Y))
    return parts


def regions() -> dict[str, Region]:
    """Regions whose proportions vary."""
    middle = {
        "torso": Region(
            None, HIP * [0, 1, 1], Y, ("pelvis", "waist", "ribs", "chest", "clavicle.L", "clavicle.R")
        ),
        "head": Region("torso", np.array([0, 1.45, -0.03]), Y, ("neck", "head")),
    }
    left = {
        "arm.L": Region("torso", SHOULDER, ARM, ("upper_arm.L", "forearm.L")),
        "hand.L": Region("arm.L", WRIST, ARM, ("hand.L",)),
        "leg.L": Region("torso", HIP, ANKLE - HIP, ("thigh.L", "shin.L")),
        "foot.L": Region("leg.L", ANKLE, TOE_OUT, ("foot.L", "toes.L")),
    }
    return middle | side_regions(left)


def plan(seed: int = 0) -> BodyPlan:
    """Body plan of the symmetric human; seeds other than 0 vary its proportions."""
    details = [
        Detail("head", np.array([0, 1.60, 0.08]), 0.055, 0.0062),
        Detail("head", np.array([0, 1.64, 0.0]), 0.09, 0.0105),
    ]
    for side, flip in (("L", np.ones(3)), ("R", FLIP)):
        details.append(Detail(f"hand.{side}", (WRIST + 0.115 * ARM + 0.01 * Z) * flip, 0.075, 0.0062))
        details.append(Detail(f"toes.{side}", (BALL + 0.045 * TOE_OUT) * flip, 0.04, 0.0085))
    default = BodyPlan(
        "human", skeleton(), surface(), tuple(details), EDGE, SPACING, STIFFNESS, POSES, True, HELD_OUT
    )
    return proportioned(default, regions(), random_scales(regions(), seed))


def asymmetric_plan(seed: int = 0) -> BodyPlan:
    """Body plan of a human whose sides differ: one arm, one leg, a bun of hair and a pouch at the back."""
    scales = random_scales(regions(), seed)
    for name, (length, girth) in SIDES_DIFFER.items():
        base = scales.get(name, (1.0, 1.0))
        scales[name] = (base[0] * length, base[1] * girth)
    default = plan()
    extra = (
        ellipsoid("head", (0.062, 1.725, -0.072), (0.040, 0.042, 0.040), blend=0.012),
        ellipsoid("pelvis", (-0.085, 1.00, -0.115), (0.062, 0.058, 0.045), blend=0.010, power=2.8),
    )
    body = Body((*default.surface.parts, *extra))
    changed = replace(default, name="human_asymmetric", surface=body, symmetric=False)
    return proportioned(changed, regions(), scales)

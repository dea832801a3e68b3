"""The procedural quadruped, a horse: skeleton and surface.

Metres; x to the left of the body, y up, z to the front; hooves at y = 0, withers about 1.55 m high.
"""

import numpy as np
from numpy.typing import NDArray

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
from datasets_gen.bodies.quadruped_poses import HELD_OUT, LIMITS, POSES
from datasets_gen.bodies.skeleton import Skeleton, hinge

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)

EDGE, SPACING, STIFFNESS = 0.0215, 0.009, 0.10

POLL, MUZZLE = np.array([0, 1.93, 0.93]), np.array([0, 1.57, 1.32])
FACE = unit(MUZZLE - POLL)
BROW = unit(np.cross(FACE, X))  # across the face, towards the forehead
DOCK = np.array([0, 1.44, -0.72])
SHOULDER = np.array([0.145, 1.20, 0.52])
ELBOW = np.array([0.15, 1.03, 0.37])
CARPUS = np.array([0.14, 0.53, 0.365])
FETLOCK = np.array([0.137, 0.17, 0.36])
HOOF = np.array([0.137, 0.03, 0.425])
HIP = np.array([0.14, 1.28, -0.47])
STIFLE = np.array([0.165, 0.98, -0.37])
HOCK = np.array([0.15, 0.60, -0.62])
HIND_FETLOCK = np.array([0.147, 0.19, -0.588])
HIND_HOOF = np.array([0.147, 0.03, -0.525])
LEG_ROOT = 1.15  # height from which all legs are scaled, so that all four hooves stay level
SAME_LENGTH = {"hind.L": "fore.L"}


def skeleton() -> Skeleton:
    """Bones of the quadruped."""
    middle = [
        hinge("hips", None, (0, 1.33, -0.42), (0, 1.33, -0.66), X),
        hinge("loin", "hips", (0, 1.33, -0.36), (0, 1.32, -0.08), X),
        hinge("chest", "loin", (0, 1.32, -0.05), (0, 1.28, 0.42), X),
        hinge("neck", "chest", (0, 1.36, 0.48), (0, 1.62, 0.69), X),
        hinge("crest", "neck", (0, 1.62, 0.69), (0, 1.86, 0.88), X),
        hinge("head", "crest", (0, 1.90, 0.92), MUZZLE, X),
        hinge("tail", "hips", DOCK, (0, 1.30, -0.87), X),
        hinge("tail_middle", "tail", (0, 1.30, -0.87), (0, 1.02, -0.92), X),
        hinge("tail_end", "tail_middle", (0, 1.02, -0.92), (0, 0.68, -0.95), X),
    ]
    left = [
        hinge("shoulder.L", "chest", (0.12, 1.47, 0.33), SHOULDER, -X),
        hinge("upper_fore.L", "shoulder.L", SHOULDER, ELBOW, -X),
        hinge("forearm.L", "upper_fore.L", ELBOW, CARPUS, -X),
        hinge("fore_cannon.L", "forearm.L", CARPUS, FETLOCK, X),
        hinge("fore_hoof.L", "fore_cannon.L", FETLOCK, HOOF, X),
        hinge("thigh.L", "hips", HIP, STIFLE, -X),
        hinge("gaskin.L", "thigh.L", STIFLE, HOCK, X),
        hinge("hind_cannon.L", "gaskin.L", HOCK, HIND_FETLOCK, -X),
        hinge("hind_hoof.L", "hind_cannon.L", HIND_FETLOCK, HIND_HOOF, X),
        hinge("ear.L", "head", (0.055, 1.985, 0.895), (0.075, 2.13, 0.90), X),
    ]
    return Skeleton((*middle, *left, *(b.mirrored() for b in left)), LIMITS)


def surface() -> Body:
    """Surface of the quadruped."""
    return Body((*_trunk(), *_head(), *_tail(), *both_sides((*_foreleg(), *_hindleg(), *_face_side()))))


def _trunk() -> list[Part]:
    back, front, height = -0.70, 0.56, 1.22
    outline = [  # position, half width, belly, back line
        (-0.70, 0.165, 1.10, 1.44), (-0.60, 0.215, 1.01, 1.500), (-0.48, 0.250, 0.98, 1.525),
        (-0.30, 0.255, 0.96, 1.520), (-0.10, 0.270, 0.925, 1.480), (0.10, 0.270, 0.900, 1.475),
        (0.28, 0.240, 0.890, 1.535), (0.40, 0.215, 0.910, 1.540), (0.50, 0.185, 0.960, 1.47),
        (0.56, 0.150, 1.01, 1.39),
    ]  # fmt: skip
    rows = [((z - back) / (front - back), w, (t - b) / 2, 0, (t + b) / 2 - height) for z, w, b, t in outline]
    neck = [(0, 0.145, 0.250), (0.25, 0.112, 0.205), (0.5, 0.088, 0.162, 0, -0.006),
        (0.78, 0.072, 0.128, 0, -0.006), (1, 0.070, 0.112)]  # fmt: skip
    return [
        sweep("hips loin chest", (0, height, back), (0, height, front), rows, caps=(0.09, 0.10), blend=0.05,
            front=Y, power=2.2),
        sweep("chest neck crest", (0, 1.30, 0.43), POLL - [0, 0.02, 0.02], neck, caps=(0.06, 0.05),
            blend=0.10),
        sweep("neck crest", (0, 1.60, 0.40), (0, 2.02, 0.855),
            [(0, 0.020, 0.030), (0.5, 0.020, 0.036), (1, 0.018, 0.026)], caps=(0.05, 0.03), blend=0.03),
    ]  # fmt: skip


def _head() -> list[Part]:
    rows = [
        (0.00, 0.082, 0.098, 0, -0.004), (0.20, 0.094, 0.134, 0, -0.022), (0.40, 0.083, 0.116, 0, -0.018),
        (0.62, 0.060, 0.080, 0, -0.002), (0.80, 0.054, 0.064), (0.93, 0.060, 0.066, 0, -0.002),
        (1.00, 0.056, 0.060, 0, -0.006),
    ]  # fmt: skip
    return [
        sweep("head", POLL, MUZZLE, rows, caps=(0.05, 0.040), blend=0.05, front=BROW, power=2.2),
        ellipsoid("head", POLL + 0.07 * BROW + 0.02 * FACE, (0.030, 0.060, 0.024), blend=0.03, axis=FACE,
            front=BROW),
        ellipsoid("head", MUZZLE + 0.040 * FACE - 0.022 * BROW, (0.060, 0.030, 0.005), blend=0.012, axis=FACE,
            front=BROW, carve=True),
    ]  # fmt: skip


def _face_side() -> list[Part]:
    eye = POLL + 0.15 * FACE + 0.052 * BROW + 0.080 * X
    nostril = MUZZLE + 0.005 * FACE + 0.030 * BROW + 0.050 * X
    return [
        ellipsoid("head", eye + 0.012 * BROW, (0.020, 0.040, 0.018), blend=0.03, axis=FACE, front=BROW),
        ellipsoid("head", eye, (0.018, 0.022, 0.016), blend=0.008, axis=FACE, front=BROW),
        ellipsoid("head", nostril, (0.014, 0.022, 0.016), blend=0.015, axis=FACE, front=BROW),
        ellipsoid("head", nostril + 0.014 * X + 0.010 * FACE, (0.010, 0.016, 0.009), blend=0.010, axis=FACE,
            front=BROW, carve=True),
        sweep("ear.L", (0.052, 1.975, 0.895), (0.072, 2.125, 0.910),
            [(0, 0.026, 0.022), (0.45, 0.033, 0.024), (1, 0.007, 0.008)], caps=(0.02, 0.012), blend=0.02),
        ellipsoid("ear.L", (0.062, 2.055, 0.935), (0.015, 0.045, 0.020), blend=0.012, axis=(0.13, 1, 0.1),
            carve=True),
    ]  # fmt: skip


def _tail() -> list[Part]:
    hair = [(0, 0.040, 0.040), (0.35, 0.056, 0.050), (0.7, 0.060, 0.050), (1, 0.030, 0.028)]
    return [
        sweep("hips tail", np.add(DOCK, (0, -0.03, 0.06)), (0, 1.32, -0.865),
            [(0, 0.050, 0.060), (0.5, 0.042, 0.045), (1, 0.040, 0.040)], caps=(0.03, 0.03), blend=0.04),
        sweep("tail tail_middle tail_end", (0, 1.33, -0.865), (0, 0.66, -0.950), hair, caps=(0.03, 0.06),
            blend=0.03),
    ]  # fmt: skip


def _foreleg() -> list[Part]:
    rows = [  # height, half width, half depth, shift, shift to the front
        (1.10, 0.085, 0.130), (1.00, 0.077, 0.108), (0.88, 0.063, 0.084), (0.74, 0.051, 0.063),
        (0.62, 0.045, 0.051), (0.54, 0.049, 0.052, 0, 0.006), (0.46, 0.039, 0.043, 0, 0.002),
        (0.34, 0.033, 0.040), (0.24, 0.034, 0.041), (0.17, 0.041, 0.047),
    ]  # fmt: skip
    top = np.array([0.152, 1.10, 0.375])
    profile = [((1.10 - y) / (1.10 - 0.17), *rest) for y, *rest in rows]
    return [
        ellipsoid("shoulder.L upper_fore.L", (0.138, 1.27, 0.43), (0.088, 0.27, 0.135), blend=0.07,
            axis=(0.05, -1, 0.42)),
        sweep("upper_fore.L forearm.L fore_cannon.L", top, FETLOCK, profile, caps=(0.07, 0.035), blend=0.06),
        ellipsoid("upper_fore.L", (0.155, 1.06, 0.345), (0.070, 0.10, 0.10), blend=0.05),
        *_pastern("fore_hoof.L", FETLOCK, np.array([0.137, 0.0, 0.43])),
    ]  # fmt: skip


def _hindleg() -> list[Part]:
    rows = [  # height, half width, half depth, position along the body
        (1.24, 0.115, 0.235, -0.510), (1.12, 0.122, 0.220, -0.485), (1.00, 0.108, 0.180, -0.455),
        (0.90, 0.088, 0.138, -0.468), (0.80, 0.068, 0.100, -0.520), (0.70, 0.053, 0.076, -0.580),
        (0.61, 0.048, 0.071, -0.622), (0.53, 0.043, 0.054, -0.613), (0.42, 0.037, 0.045, -0.600),
        (0.30, 0.036, 0.043, -0.593), (0.19, 0.043, 0.050, -0.588),
    ]  # fmt: skip
    profile = [((1.24 - y) / (1.24 - 0.19), w, d, 0, z + 0.588) for y, w, d, z in rows]
    return [
        sweep(
            "thigh.L gaskin.L hind_cannon.L",
            (0.150, 1.24, -0.588),
            HIND_FETLOCK,
            profile,
            caps=(0.10, 0.035),
            blend=0.07,
        ),
        ellipsoid("thigh.L", (0.135, 1.24, -0.56), (0.115, 0.22, 0.19), blend=0.06),
        *_pastern("hind_hoof.L", HIND_FETLOCK, HIND_HOOF * [1, 0, 1]),
    ]


def _pastern(bone: str, fetlock: Array, ground: Array) -> list[Part]:
    coronet = fetlock + 0.60 * (ground - fetlock)
    sole = np.add(ground, (0, 0.010, 0))
    return [
        sweep(
            bone,
            fetlock,
            coronet,
            [(0, 0.041, 0.046), (0.5, 0.036, 0.040), (1, 0.042, 0.047)],
            caps=(0.03, 0.02),
            blend=0.02,
        ),
        sweep(
            bone,
            coronet,
            sole,
            [(0, 0.046, 0.050), (1, 0.062, 0.070)],
            caps=(0.010, 0.010),
            blend=0.012,
            power=2.6,
        ),
    ]


def regions() -> dict[str, Region]:
    """Regions whose proportions vary."""
    middle = {
        "trunk": Region(
            None, np.array([0, LEG_ROOT, 0]), Z, ("hips", "loin", "chest", "shoulder.L", "shoulder.R")
        ),
        "neck": Region("trunk", np.array([0, 1.36, 0.48]), POLL - [0, 1.36, 0.48], ("neck", "crest")),
        "head": Region("neck", POLL, FACE, ("head", "ear.L", "ear.R")),
        "tail": Region("trunk", DOCK, -Y, ("tail", "tail_middle", "tail_end")),
    }
    fore = ("upper_fore.L", "forearm.L", "fore_cannon.L", "fore_hoof.L")
    hind = ("thigh.L", "gaskin.L", "hind_cannon.L", "hind_hoof.L")
    left = {
        "fore.L": Region("trunk", SHOULDER * [1, 0, 1] + LEG_ROOT * Y, Y, fore),
        "hind.L": Region("trunk", HIP * [1, 0, 1] + LEG_ROOT * Y, Y, hind),
    }
    return middle | side_regions(left)


def plan(seed: int = 0) -> BodyPlan:
    """Body plan of the quadruped; seeds other than 0 vary its proportions."""
    details = [
        Detail("head", POLL + 0.20 * FACE, 0.16, 0.0150),
        Detail("head", MUZZLE, 0.07, 0.0125),
    ]
    joints = {
        "fore_cannon": (CARPUS, FETLOCK),
        "fore_hoof": (HOOF,),
        "hind_cannon": (HOCK, HIND_FETLOCK),
        "hind_hoof": (HIND_HOOF,),
    }
    for side, flip in (("L", np.ones(3)), ("R", FLIP)):
        details += [
            Detail(f"{bone}.{side}", p * flip, 0.10, 0.0145)
            for bone, points in joints.items()
            for p in points
        ]
        details.append(Detail(f"ear.{side}", np.array([0.062, 2.06, 0.91]) * flip, 0.05, 0.011))
    default = BodyPlan(
        "quadruped", skeleton(), surface(), tuple(details), EDGE, SPACING, STIFFNESS, POSES, True, HELD_OUT
    )
    scales = random_scales(regions(), seed, same_length=SAME_LENGTH)
    return proportioned(default, regions(), scales)

"""The procedural human: skeleton, surface and poses."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from datasets_gen.bodies import BodyPlan, Detail
from datasets_gen.implicit import Body, Ellipsoid, Part, Sweep, unit
from datasets_gen.skeleton import Bone, Pose, Skeleton, bone

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)
FLIP = np.array([-1.0, 1, 1])


def mirrored(part: Part) -> Part:
    bones = tuple(b[:-2] + ".R" if b.endswith(".L") else b for b in part.bones)
    if isinstance(part, Ellipsoid):
        return replace(part, bones=bones, center=part.center * FLIP, axes=part.axes * FLIP)
    profile = part.profile * np.array([1, 1, 1, -1, 1.0])
    return replace(
        part, bones=bones, start=part.start * FLIP, end=part.end * FLIP, front=part.front * FLIP, profile=profile
    )


def ball(name: str, parent: str | None, head: ArrayLike, tail: ArrayLike, flex: ArrayLike) -> Bone:
    start, end = np.asarray(head, float), np.asarray(tail, float)
    return Bone(name, parent, start, end, np.stack([np.asarray(flex, float), unit(end - start), Z]))


ARM = np.radians(48)
D = np.array([np.cos(ARM), -np.sin(ARM), 0.0])
SHOULDER = np.array([0.175, 1.415, -0.015])
ELBOW = SHOULDER + 0.28 * D
WRIST = ELBOW + 0.25 * D + [0, 0, 0.015]
HAND = unit(WRIST - ELBOW)


def skeleton() -> Skeleton:
    middle = [
        ball("pelvis", None, (0, 0.94, -0.005), (0, 1.03, -0.005), X),
        ball("waist", "pelvis", (0, 1.04, -0.005), (0, 1.13, -0.005), X),
        ball("ribs", "waist", (0, 1.13, -0.005), (0, 1.24, -0.01), X),
        ball("chest", "ribs", (0, 1.24, -0.01), (0, 1.42, -0.02), X),
        ball("neck", "chest", (0, 1.45, -0.025), (0, 1.55, -0.01), X),
        ball("head", "neck", (0, 1.56, -0.01), (0, 1.72, 0), X),
    ]
    left = [
        bone("clavicle.L", "chest", (0.03, 1.42, 0), SHOULDER, Z),
        ball("upper_arm.L", "clavicle.L", SHOULDER, ELBOW, -X),
        bone("forearm.L", "upper_arm.L", ELBOW, WRIST, np.cross(D, Z)),
        bone("hand.L", "forearm.L", WRIST, WRIST + 0.17 * HAND, -Z),
        ball("thigh.L", "pelvis", (0.088, 0.90, 0), (0.098, 0.49, 0.005), -X),
        bone("shin.L", "thigh.L", (0.098, 0.49, 0.0), (0.105, 0.085, -0.03), X),
        bone("foot.L", "shin.L", (0.105, 0.085, -0.03), (0.115, 0.025, 0.11), -X),
        bone("toes.L", "foot.L", (0.115, 0.025, 0.11), (0.12, 0.02, 0.18), -X),
    ]
    return Skeleton((*middle, *left, *(b.mirrored() for b in left)))


def sweep(bones: str, start: ArrayLike, end: ArrayLike, rows: ArrayLike, caps: tuple[float, float],
          blend: float = 0.03, front: ArrayLike = Z) -> Sweep:
    profile = np.array([[*row, *([0.0] * (5 - len(row)))] for row in rows], dtype=float)
    return Sweep(bones=tuple(bones.split()), start=np.asarray(start, float), end=np.asarray(end, float),
                 front=np.asarray(front, float), profile=profile, caps=caps, blend=blend)


def ellipsoid(bones: str, center: ArrayLike, radii: ArrayLike, blend: float = 0.03, carve: bool = False,
              axes: ArrayLike = np.eye(3)) -> Ellipsoid:
    return Ellipsoid(bones=tuple(bones.split()), center=np.asarray(center, float), radii=np.asarray(radii, float),
                     axes=np.asarray(axes, float), blend=blend, carve=carve)


def surface() -> Body:
    y0, y1 = 0.88, 1.46
    torso_rows = [
        (0.88, .145, .095, -.008), (0.95, .162, .108, -.012), (1.02, .150, .10, -.004), (1.10, .133, .09, .004),
        (1.20, .145, .103, .004), (1.29, .160, .113, .0), (1.36, .158, .10, -.01), (1.42, .12, .075, -.02),
        (1.46, .07, .058, -.025),
    ]
    rows = [((y - y0) / (y1 - y0), w, d, 0, z) for y, w, d, z in torso_rows]
    middle: list[Part] = [
        sweep("pelvis waist ribs chest", (0, y0, 0), (0, y1, 0), rows, (.05, .03)),
        sweep("neck", (0, 1.42, -.03), (0, 1.58, -.008), [(0, .064, .064), (.5, .056, .058), (1, .056, .06)], (.03, .03), .05),
        ellipsoid("head", (0, 1.655, -.012), (.077, .098, .095), .03),
        ellipsoid("head", (0, 1.60, .03), (.056, .068, .062), .04),
        ellipsoid("head", (0, 1.555, .068), (.024, .02, .02), .03),
        ellipsoid("head", (0, 1.625, .095), (.013, .025, .018), .02),
    ]
    left: list[Part] = [
        ellipsoid("chest", (.075, 1.32, .075), (.075, .055, .04), .05),
        ellipsoid("pelvis", (.075, .92, -.075), (.07, .08, .06), .05),
        sweep("clavicle.L", (.05, 1.40, -.02), SHOULDER, [(0, .06, .06), (.6, .06, .06), (1, .062, .06)], (.04, .04), .05),
        ellipsoid("upper_arm.L", SHOULDER + .02 * D, (.06, .062, .06), .04),
        sweep("upper_arm.L", SHOULDER, ELBOW, [(0, .05, .055), (.4, .046, .052, 0, .004), (.8, .04, .042), (1, .038, .04)], (.03, .03), .04),
        sweep("forearm.L", ELBOW, WRIST, [(0, .038, .04), (.25, .043, .044), (.6, .034, .035), (.9, .025, .03), (1, .024, .03)], (.03, .02), .03),
        sweep("hand.L", WRIST, WRIST + .09 * HAND, [(0, .022, .028), (.5, .018, .038), (1, .014, .042)], (.02, .012), .025),
        *(
            sweep("hand.L", WRIST + .085 * HAND + [0, 0, z], WRIST + .085 * HAND + [0, 0, z] + length * unit(HAND + [0, 0, fan]),
                  [(0, .0095, .0095), (.7, .0085, .0085), (1, .0075, .0075)], (.008, .0075), .01)
            for z, length, fan in ((.033, .065, .14), (.011, .075, .04), (-.012, .07, -.06), (-.033, .055, -.17))
        ),
        sweep("hand.L", WRIST + .02 * HAND + [0, 0, .02], WRIST + .075 * HAND + [0, 0, .075], [(0, .017, .017), (.6, .012, .012), (1, .009, .009)], (.015, .009), .02),
        sweep("thigh.L", (.088, .90, 0), (.098, .49, .005), [(0, .085, .092), (.3, .084, .092, 0, .006), (.7, .066, .072, 0, .006), (1, .055, .06)], (.05, .04), .05),
        sweep("shin.L", (.098, .49, .005), (.105, .085, -.03), [(0, .054, .058), (.25, .057, .06, 0, -.012), (.6, .043, .046, 0, -.008), (.9, .033, .036), (1, .033, .038)], (.04, .03), .03),
        sweep("foot.L toes.L", (.103, .0, -.06), (.12, .0, .17), [(0, .032, .035, 0, .034), (.25, .034, .04, 0, .038), (.55, .038, .032, 0, .031), (.8, .045, .02, 0, .02), (1, .04, .015, 0, .015)], (.02, .02), .03, front=Y),
        ellipsoid("head", (.078, 1.635, -.01), (.01, .028, .018), .012),
        ellipsoid("head", (.032, 1.648, .094), (.018, .012, .014), .02, True),
    ]
    return Body((*middle, *left, *(mirrored(p) for p in left)))


def _both(**angles: tuple[float, float, float]) -> dict[str, tuple[float, float, float]]:
    return {f"{k}.{s}": v for k, v in angles.items() for s in "LR"}


POSES: dict[str, Pose] = {
    "rest": {},
    "tpose": _both(upper_arm=(0, 0, 48)),
    "arms_up": _both(clavicle=(20, 0, 0), upper_arm=(0, 0, 108), forearm=(15, 0, 0)),
    "walk": {
        "upper_arm.L": (-25, 0, -36), "upper_arm.R": (25, 0, -36), "forearm.L": (15, 0, 0), "forearm.R": (30, 0, 0),
        "thigh.L": (28, 0, 0), "shin.L": (12, 0, 0), "thigh.R": (-18, 0, 0), "shin.R": (25, 0, 0), "foot.R": (-10, 0, 0),
    },
    "sit": {**_both(upper_arm=(30, 0, -36), forearm=(40, 0, 0), thigh=(85, 0, 4), shin=(85, 0, 0))},
    "bend": {**_both(upper_arm=(60, 0, -30)), "pelvis": (20, 0, 0), "waist": (18, 0, 0), "ribs": (18, 0, 0),
             "chest": (14, 0, 0), "thigh.L": (20, 0, 0), "thigh.R": (20, 0, 0)},
    "twist": {"waist": (0, 15, 0), "ribs": (0, 18, 0), "chest": (0, 18, 0), "neck": (0, 15, 0), "head": (0, 15, 0),
              "upper_arm.R": (70, 0, -20), "forearm.R": (40, 0, 0)},
    "lunge": {"thigh.L": (75, 0, 6), "shin.L": (80, 0, 0), "thigh.R": (-30, 0, 4), "shin.R": (35, 0, 0),
              "foot.R": (10, 0, 0), "upper_arm.L": (10, 0, 30), "upper_arm.R": (95, 0, -20)},
}


def plan(seed: int = 0) -> BodyPlan:
    hand, foot = WRIST + .1 * HAND, np.array([.115, .02, .1])
    details = []
    for side in (np.ones(3), FLIP):
        details += [Detail(hand * side, .1, .0065), Detail(foot * side, .1, .012)]
    details.append(Detail(np.array([0, 1.62, .05]), .09, .009))
    return BodyPlan("human", skeleton(), surface(), tuple(details), .017, .005, POSES, True)

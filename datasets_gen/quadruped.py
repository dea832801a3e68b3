"""The procedural quadruped, a horse: skeleton, surface and poses."""

import numpy as np

from datasets_gen.bodies import BodyPlan, Detail
from datasets_gen.implicit import Body, Part, ellipsoid, sweep, unit
from datasets_gen.proportions import FLIP, both_sides
from datasets_gen.skeleton import Pose, Skeleton, ball, hinge

X, Y, Z = np.eye(3)

S, E, C, F, T = (np.array(p) for p in ((.15, 1.28, .44), (.155, .99, .27), (.14, .57, .31), (.135, .20, .30), (.135, .03, .36)))
H, K, G, B, P = (np.array(p) for p in ((.15, 1.30, -.48), (.175, .98, -.26), (.15, .62, -.60), (.145, .21, -.55), (.145, .03, -.49)))
WITHERS, POLL, MUZZLE = np.array([0, 1.40, .45]), np.array([0, 1.98, .98]), np.array([0, 1.60, 1.36])
DOCK = np.array([0, 1.43, -.68])


def skeleton() -> Skeleton:
    mid = [
        ball("hips", None, (0, 1.34, -.45), (0, 1.34, -.62), X),
        ball("loin", "hips", (0, 1.34, -.40), (0, 1.33, -.08), X),
        ball("chest", "loin", (0, 1.33, -.05), (0, 1.30, .42), X),
        ball("neck", "chest", (0, 1.36, .46), (0, 1.58, .63), X),
        ball("crest", "neck", (0, 1.58, .63), (0, 1.80, .82), X),
        ball("head", "crest", (0, 1.92, .94), MUZZLE, X),
        ball("tail", "hips", DOCK, (0, 1.22, -.86), X),
        ball("tail_end", "tail", (0, 1.22, -.86), (0, .75, -.95), X),
    ]
    left = [
        ball("shoulder.L", "chest", (.13, 1.45, .34), S, -X),
        hinge("upper_fore.L", "shoulder.L", S, E, -X),
        hinge("forearm.L", "upper_fore.L", E, C, -X),
        hinge("fore_cannon.L", "forearm.L", C, F, X),
        hinge("fore_hoof.L", "fore_cannon.L", F, T, X),
        ball("thigh.L", "hips", H, K, -X),
        hinge("gaskin.L", "thigh.L", K, G, X),
        hinge("hind_cannon.L", "gaskin.L", G, B, -X),
        hinge("hind_hoof.L", "hind_cannon.L", B, P, X),
    ]
    return Skeleton((*mid, *left, *(b.mirrored() for b in left)))


def surface() -> Body:
    mid: list[Part] = [
        sweep("hips loin chest", (0, 1.30, -.60), (0, 1.24, .48), [(0, .19, .21, 0, .0), (.2, .25, .26), (.45, .26, .26, 0, -.02), (.7, .25, .30, 0, -.03), (.9, .21, .28, 0, -.01), (1, .16, .22)], caps=(.12, .12), blend=.05, front=Y),
        sweep("neck crest", (0, 1.34, .40), (0, 1.90, .93), [(0, .14, .25), (.3, .105, .19), (.7, .075, .13), (1, .065, .11)], caps=(.08, .05), blend=.12, front=Y),
        sweep("head", (0, 1.93, .95), MUZZLE, [(0, .075, .10), (.3, .095, .125, 0, -.01), (.65, .062, .082), (.9, .055, .065), (1, .052, .06)], caps=(.05, .045), blend=.05, front=Y),
        sweep("tail tail_end", DOCK, (0, .72, -.96), [(0, .045, .045), (.3, .05, .05), (.7, .07, .06), (1, .03, .03)], caps=(.05, .06), blend=.05, front=Z),
    ]
    left: list[Part] = [
        ellipsoid("shoulder.L chest", (.13, 1.30, .38), (.12, .24, .15), blend=.08),
        sweep("upper_fore.L", S, E, [(0, .09, .13), (1, .085, .11)], caps=(.06, .05), blend=.08),
        sweep("forearm.L", E, C, [(0, .075, .10), (.4, .06, .075), (.85, .045, .05), (1, .05, .055)], caps=(.05, .04), blend=.05),
        sweep("fore_cannon.L", C, F, [(0, .046, .05), (.3, .036, .042), (.8, .035, .042), (1, .042, .048)], caps=(.03, .03), blend=.03),
        sweep("fore_hoof.L", F, T, [(0, .04, .045), (.5, .04, .045), (.8, .058, .065), (1, .064, .07)], caps=(.03, .025), blend=.02, front=Y),
        ellipsoid("thigh.L", (.14, 1.18, -.43), (.13, .25, .22), blend=.1),
        sweep("thigh.L", H, K, [(0, .12, .18), (1, .10, .13)], caps=(.06, .06), blend=.08),
        sweep("gaskin.L", K, G, [(0, .085, .12), (.4, .065, .085), (.85, .045, .055), (1, .05, .06)], caps=(.05, .05), blend=.06),
        sweep("hind_cannon.L", G, B, [(0, .046, .058), (.3, .038, .046), (.8, .036, .043), (1, .043, .05)], caps=(.03, .03), blend=.03),
        sweep("hind_hoof.L", B, P, [(0, .04, .045), (.5, .04, .045), (.8, .058, .065), (1, .064, .07)], caps=(.03, .025), blend=.02, front=Y),
        sweep("head", (.05, 1.98, .93), (.075, 2.12, .93), [(0, .03, .025), (.4, .035, .022), (1, .01, .01)], caps=(.02, .01), blend=.02),
    ]
    return Body((*mid, *both_sides(left)))


POSES: dict[str, Pose] = {
    "stand": {},
    "walk": {"shoulder.L": (10, 0, 0), "upper_fore.L": (20, 0, 0), "forearm.L": (10, 0, 0), "fore_cannon.L": (25, 0, 0),
             "upper_fore.R": (-15, 0, 0), "forearm.R": (-10, 0, 0), "thigh.L": (-18, 0, 0), "gaskin.L": (8, 0, 0),
             "thigh.R": (20, 0, 0), "gaskin.R": (15, 0, 0), "neck": (6, 0, 0)},
    "graze": {"neck": (48, 0, 0), "crest": (32, 0, 0), "head": (5, 0, 0), "upper_fore.L": (14, 0, 0), "upper_fore.R": (-10, 0, 0)},
    "rear": {"hips": (-50, 0, 0), "thigh.L": (35, 0, 0), "thigh.R": (25, 0, 0), "gaskin.L": (15, 0, 0), "gaskin.R": (15, 0, 0),
             "upper_fore.L": (45, 0, 0), "forearm.L": (20, 0, 0), "fore_cannon.L": (80, 0, 0), "upper_fore.R": (30, 0, 0), "fore_cannon.R": (90, 0, 0)},
    "turn_head": {"neck": (0, 30, 25), "crest": (0, 30, 20), "head": (0, 10, 15)},
    "gallop_extended": {"upper_fore.L": (50, 0, 0), "forearm.L": (15, 0, 0), "upper_fore.R": (40, 0, 0), "fore_cannon.R": (20, 0, 0),
                        "thigh.L": (-40, 0, 0), "thigh.R": (-30, 0, 0), "neck": (20, 0, 0), "tail": (-40, 0, 0)},
    "gallop_collected": {"upper_fore.L": (-25, 0, 0), "forearm.L": (-10, 0, 0), "fore_cannon.L": (50, 0, 0), "upper_fore.R": (-20, 0, 0),
                         "fore_cannon.R": (60, 0, 0), "thigh.L": (40, 0, 0), "thigh.R": (35, 0, 0), "loin": (12, 0, 0), "gaskin.L": (20, 0, 0), "gaskin.R": (20, 0, 0)},
    "jump": {"hips": (-25, 0, 0), "upper_fore.L": (50, 0, 0), "fore_cannon.L": (110, 0, 0), "upper_fore.R": (45, 0, 0), "fore_cannon.R": (110, 0, 0),
             "thigh.L": (-25, 0, 0), "thigh.R": (-25, 0, 0)},
}


def plan(seed: int = 0) -> BodyPlan:
    details = [Detail("head", np.array([0, 1.75, 1.15]), .28, .014)]
    for side, flip in (("L", np.ones(3)), ("R", FLIP)):
        for bone, p in (("fore_cannon", C), ("fore_cannon", F), ("fore_hoof", T), ("hind_cannon", G), ("hind_cannon", B), ("hind_hoof", P)):
            details.append(Detail(f"{bone}.{side}", p * flip, .15, .014))
    return BodyPlan("quadruped", skeleton(), surface(), tuple(details), .025, .010, POSES, True)

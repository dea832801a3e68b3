"""Poses of the quadruped: (flexion, twist, swing) in degrees of the bones that turn.

Positive flexion swings a leg's upper bone forward and closes each joint below it; it lowers the front for the
spine and lifts the tail. Positive swing spreads a leg.
"""

from datasets_gen.bodies.skeleton import Angles, Limits, Pose

FIXED = (0.0, 0.0)

LIMITS: Limits = {
    "loin": ((-12, 15), (-5, 5), (-10, 10)), "chest": ((-8, 12), (-8, 8), (-12, 12)),
    "neck": ((-30, 75), (-20, 20), (-45, 45)), "crest": ((-25, 45), (-20, 20), (-40, 40)),
    "head": ((-55, 40), (-25, 25), (-20, 20)), "tail": ((-15, 70), (-20, 20), (-35, 35)),
    "tail_middle": ((-30, 40), (-20, 20), (-30, 30)), "tail_end": ((-30, 40), (-20, 20), (-30, 30)),
    "ear": ((-40, 40), (-60, 60), (-20, 20)), "shoulder": ((-15, 15), FIXED, FIXED),
    "upper_fore": ((-25, 45), (-8, 8), (-10, 15)), "forearm": ((-15, 75), FIXED, FIXED),
    "fore_cannon": ((-5, 115), FIXED, FIXED), "fore_hoof": ((-40, 80), FIXED, FIXED),
    "thigh": ((-45, 45), (-8, 8), (-8, 20)), "gaskin": ((-25, 65), FIXED, FIXED),
    "hind_cannon": ((-25, 75), FIXED, FIXED), "hind_hoof": ((-40, 80), FIXED, FIXED),
}  # fmt: skip
"""Ranges of motion about the stand: of the legs as in horses at walk, trot and jump [BC13], rounded outward.

[BC13] W. Back, H. M. Clayton (eds.), "Equine locomotion", 2nd ed., 2013.
"""


def fore(
    side: str, shoulder: float, upper: float, elbow: float, carpus: float, hoof: float = 0, spread: float = 0
) -> dict[str, Angles]:
    """Flexions of one foreleg from top to bottom, and how far it is spread."""
    names = ("shoulder", "upper_fore", "forearm", "fore_cannon", "fore_hoof")
    pose: dict[str, Angles] = {
        f"{n}.{side}": (a, 0.0, 0.0)
        for n, a in zip(names, (shoulder, upper, elbow, carpus, hoof), strict=True)
    }
    return pose | {f"upper_fore.{side}": (upper, 0.0, spread)}


def hind(
    side: str, hip: float, stifle: float, hock: float, hoof: float = 0, spread: float = 0
) -> dict[str, Angles]:
    """Flexions of one hind leg from top to bottom, and how far it is spread."""
    names = ("thigh", "gaskin", "hind_cannon", "hind_hoof")
    pose: dict[str, Angles] = {
        f"{n}.{side}": (a, 0.0, 0.0) for n, a in zip(names, (hip, stifle, hock, hoof), strict=True)
    }
    return pose | {f"thigh.{side}": (hip, 0.0, spread)}


POSES: dict[str, Pose] = {
    "stand": {},
    "walk": {
        **fore("L", 4, 16, 6, 4, 0), **fore("R", -4, -12, 2, 6, 25), **hind("L", -16, -4, -4, 15),
        **hind("R", 14, 6, 8, 0, 2), "neck": (6, 0, 0), "tail": (6, 0, 0),
    },
    "trot": {
        **fore("L", 6, 22, 30, 60, 40), **fore("R", -4, -10, -6, 0, 10), **hind("R", 14, 24, 32, 30, 3),
        **hind("L", -16, -8, -8, 10), "neck": (-6, 0, 0), "crest": (8, 0, 0), "tail": (20, 0, 0),
    },
    "gallop_extended": {
        **fore("L", 8, 40, 12, 0, 10), **fore("R", 8, 28, 16, 26, 30), **hind("L", -30, -14, -16, 20),
        **hind("R", -22, -12, -10, 25), "neck": (18, 0, 0), "crest": (6, 0, 0), "head": (-14, 0, 0),
        "loin": (-3, 0, 0), "tail": (45, 0, 0), "tail_middle": (15, 0, 0),
    },
    "gallop_collected": {
        **fore("L", -4, -12, 24, 80, 50, -3), **fore("R", -2, -2, 38, 100, 50, -3),
        **hind("L", 30, 12, 8, 10, 9), **hind("R", 20, 20, 22, 10, 8), "loin": (10, 0, 0), "hips": (-4, 0, 0),
        "neck": (-10, 0, 0), "crest": (12, 0, 0), "tail": (35, 0, 0),
    },
    "graze": {
        "hips": (6, 0, 0), "chest": (6, 0, 0), "neck": (68, 0, 0), "crest": (38, 0, 0), "head": (-46, 0, 0),
        **fore("L", 5, 31, 4, 0, -16, 3), **fore("R", -3, -3, 2, 2, 8, 3), **hind("L", 7, -4, -4, 0),
        **hind("R", 3, -4, -4, 4), "tail": (8, 0, 6),
    },
    "rear": {
        "hips": (-44, 0, 0), "loin": (-6, 0, 0), **hind("L", -16, 22, 34, 0, 4),
        **hind("R", -26, 10, 30, 0, 4), **fore("L", 4, 34, 40, 80, 40), **fore("R", 2, 22, 34, 95, 40),
        "neck": (14, 0, 0), "crest": (16, 0, 0), "head": (8, 0, 0), "tail": (15, 0, 0),
    },
    "turn_head": {
        "chest": (0, 0, 8), "neck": (0, 0, 32), "crest": (6, 0, 30), "head": (6, 0, 14), "tail": (10, 0, 20),
        "tail_middle": (0, 0, 12),
    },
    "jump": {
        "hips": (-22, 0, 0), **hind("L", -34, -14, -16, 20), **hind("R", -26, -10, -12, 25),
        **fore("L", 8, 40, 56, 100, 40), **fore("R", 8, 34, 52, 95, 40), "neck": (24, 0, 0),
        "tail": (30, 0, 0),
    },
    "buck": {
        "hips": (24, 0, 0), "loin": (6, 0, 0), **fore("L", 2, 14, 10, 0, 0), **fore("R", 0, 8, 10, 0, 0),
        **hind("L", -42, -10, -14, 30), **hind("R", -30, -4, -6, 30), "neck": (22, 0, 0), "crest": (10, 0, 0),
        "tail": (55, 0, 0), "tail_middle": (20, 0, 0),
    },
}  # fmt: skip

HELD_OUT: dict[str, Pose] = {
    "paw": {
        **fore("R", 4, 30, 44, 62, 30), **fore("L", -2, -4, 0, 0, 4), **hind("L", -6, -2, 0, 6),
        **hind("R", 8, 4, 4, 0), "neck": (30, 0, -10), "crest": (20, 0, -12), "head": (-18, 0, 0),
        "tail": (14, 0, -12),
    },
    "canter": {
        **fore("L", 6, 30, 18, 10, 12), **fore("R", 0, -8, 18, 62, 40), **hind("L", 24, 8, 10, 4, 4),
        **hind("R", -20, -6, -6, 22), "hips": (-8, 0, 0), "loin": (3, 0, 0), "neck": (-6, 0, 6),
        "crest": (10, 0, 8), "head": (4, 0, 0), "tail": (30, 0, 14),
    },
}  # fmt: skip
"""Poses that are built where they are asked for by name, on which nothing was tuned."""

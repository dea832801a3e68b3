"""Poses of the quadruped: (flexion, twist, swing) in degrees of the bones that turn.

Positive flexion swings a leg's upper bone forward and closes each joint below it; it lowers the front for the
spine and lifts the tail. Positive swing spreads a leg.
"""

from datasets_gen.bodies.skeleton import Angles, Pose


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

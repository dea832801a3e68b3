"""Poses of the hand: (flexion, twist, swing) in degrees of the bones that turn.

Positive flexion closes a finger and bends the wrist to the palm; positive swing leans a finger away from the
thumb, to the side of the little finger. Bones of the thumb close towards the palm; positive swing of its root
draws it to the index finger, negative swing sets it opposite to the fingers.
"""

from datasets_gen.bodies.skeleton import Angles, Limits, Pose

FINGERS = ("index", "middle", "ring", "little")
FIXED = (0.0, 0.0)

LIMITS: Limits = {
    "palm": ((-65, 75), FIXED, (-25, 35)),
    "thumb_root": ((-25, 50), (-20, 45), (-35, 40)),
    "thumb": ((-10, 60), FIXED, FIXED),
    "thumb_tip": ((-20, 80), FIXED, FIXED),
    **dict.fromkeys(FINGERS, ((-30, 90), FIXED, (-20, 20))),
    **{f"{name}_middle": ((0, 105), FIXED, FIXED) for name in FINGERS},
    **{f"{name}_tip": ((-5, 80), FIXED, FIXED) for name in FINGERS},
}
"""Ranges of motion of healthy adults about the rest pose, degrees, as in goniometry [NW16].

[NW16] C. C. Norkin, D. J. White, "Measurement of joint motion: a guide to goniometry", 5th ed., 2016.
"""


def finger(
    name: str, knuckle: float, middle: float = 0, tip: float = 0, lean: float = 0
) -> dict[str, Angles]:
    """Angles of one finger from its knuckle to its tip."""
    return {
        name: (knuckle, 0, lean), f"{name}_middle": (middle, 0, 0), f"{name}_tip": (tip, 0, 0),
    }  # fmt: skip


def thumb(
    root: float, joint: float = 0, tip: float = 0, draw: float = 0, turn: float = 0
) -> dict[str, Angles]:
    """Angles of the thumb from its root to its tip."""
    return {"thumb_root": (root, turn, draw), "thumb": (joint, 0, 0), "thumb_tip": (tip, 0, 0)}


def closed(*names: str) -> dict[str, Angles]:
    """Fingers closed as in a fist."""
    bent = {"index": (76, 92, 48, -2), "middle": (79, 95, 50, 0), "ring": (79, 95, 50, 2),
        "little": (70, 86, 40, 4)}  # fmt: skip
    found: dict[str, Angles] = {}
    for name in names:
        found |= finger(name, *bent[name])
    return found


POSES: dict[str, Pose] = {
    "rest": {},
    "relaxed": {
        **finger("index", 22, 24, 10), **finger("middle", 28, 30, 12), **finger("ring", 32, 32, 14),
        **finger("little", 36, 30, 12), **thumb(8, 10, 14), "palm": (-12, 0, 0),
    },
    "spread": {
        **finger("index", -8, 0, 0, -12), **finger("middle", -6), **finger("ring", -6, 0, 0, 8),
        **finger("little", -8, 0, 0, 14), **thumb(-20, -6, -10, -4), "palm": (-8, 0, 0),
    },
    "fist": {**closed(*FINGERS), **thumb(2, 14, 24)},
    "point": {**closed("middle", "ring", "little"), **finger("index", 4, 3, 2), **thumb(14, 22, 24)},
    "victory": {
        **closed("ring", "little"), **finger("index", 0, 2, 0, -9), **finger("middle", -2, 2, 0, 8),
        **thumb(16, 24, 24),
    },
    "thumb_up": {**closed(*FINGERS), **thumb(-20, -6, -14)},
    "pinch": {
        **finger("index", 44, 48, 22), **finger("middle", 20, 22, 10), **finger("ring", 14, 18, 8, 3),
        **finger("little", 10, 14, 6, 8), **thumb(10, 14, 16),
    },
    "claw": {
        **finger("index", -10, 72, 40, -6), **finger("middle", -10, 74, 42), **finger("ring", -10, 74, 42, 4),
        **finger("little", -8, 70, 38, 10), **thumb(-8, 20, 40), "palm": (-20, 0, 0),
    },
    "grip": {
        **finger("index", 40, 40, 20, -3), **finger("middle", 44, 44, 22), **finger("ring", 47, 45, 22, 2),
        **finger("little", 50, 44, 20, 5), **thumb(2, 14, 20, -14), "palm": (-20, 0, 0),
    },
    "horns": {
        **closed("middle", "ring"), **finger("index", 2, 2, 2, -4), **finger("little", 2, 4, 2, 8),
        **thumb(14, 22, 20),
    },
    "bent_wrist": {
        "palm": (52, 0, 14), **finger("index", 18, 14, 6), **finger("middle", 24, 18, 8),
        **finger("ring", 28, 20, 8), **finger("little", 32, 20, 8), **thumb(0, 10, 8),
    },
}  # fmt: skip
